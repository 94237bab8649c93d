// Ranks, tests and the answer, as reporting/leaderboard/contest.py, equivalence.py and answer.py compute them.
"use strict";
const Ranking = (function () {
  const COVERAGE = 0.9, LEVEL = 0.05, LEAST = 5, NEAR = 1.25, FASTER = 1.2, NAMED = 4, EXACT_PAIRS = 50, GOOD = 1.3, FLOOR = 0.01, SHORT = 5, ENOUGH = 0.95, MEAN = 1, FLOORS = ["mean", "straight-line"], LITTLE = 0.5;
  const EQUAL = "as good", WORSE = "worse", OPEN = "not settled", FEW = "too few";
  const SINGLE = { ships: "ship", problems: "problem", "seeds of one problem": "seed of one problem" };
  const NOTHING = "No two methods were compared under these conditions.";

  function median(values) {
    const v = values.filter(function (x) { return x !== null; }).sort(function (a, b) { return a - b; });
    if (!v.length) return NaN;
    const low = v[(v.length - 1) >> 1], high = v[v.length >> 1];
    return low === high ? low : (low + high) / 2;
  }
  function averageRanks(values) {
    const order = values.map(function (_, i) { return i; }).sort(function (a, b) { return values[a] - values[b]; });
    const ranks = new Array(values.length);
    for (let first = 0; first < order.length;) {
      let last = first;
      while (last + 1 < order.length && values[order[last + 1]] === values[order[first]]) last++;
      for (let i = first; i <= last; i++) ranks[order[i]] = (first + last) / 2 + 1;
      first = last + 1;
    }
    return ranks;
  }
  function logRatio(a, b) { return a === Infinity && b === Infinity ? 0 : Math.log(a) - Math.log(b); }
  function normalTail(z) { // P(|Z| > z), by the continued fraction or the series of the error function
    const x = z / Math.SQRT2;
    if (x < 2.5) {
      let sum = x, term = x;
      for (let n = 1; n < 200; n++) { term *= -x * x / n; sum += term / (2 * n + 1); if (Math.abs(term) < 1e-18) break; }
      return Math.max(0, 1 - 2 / Math.sqrt(Math.PI) * sum);
    }
    let f = 0;
    for (let n = 60; n >= 1; n--) f = n / 2 / (x + f);
    return Math.exp(-x * x) / Math.sqrt(Math.PI) / (x + f);
  }
  // p of both one-sided signed-rank tests of log ratios d: that they lie below zero, above zero.
  function signedRank(d) {
    d = d.filter(function (x) { return Math.abs(x) > 1e-12; });
    const n = d.length;
    if (!n) return { less: 1, greater: 1 };
    const size = d.map(function (x) { return Math.round(Math.abs(x) * 1e9) / 1e9; });
    const ranks = averageRanks(size), counts = new Map();
    size.forEach(function (x) { counts.set(x, (counts.get(x) || 0) + 1); });
    let plus = 0;
    d.forEach(function (x, i) { if (x > 0) plus += ranks[i]; });
    const total = n * (n + 1) / 2;
    if (n <= EXACT_PAIRS && counts.size === n) {
      let ways = [1];
      for (let k = 1; k <= n; k++) {
        const next = new Array(ways.length + k).fill(0);
        ways.forEach(function (w, i) { next[i] += w; next[i + k] += w; });
        ways = next;
      }
      const upTo = function (most) {
        let below = 0;
        for (let i = 0; i <= most; i++) below += ways[i];
        return below / Math.pow(2, n);
      };
      return { less: upTo(plus), greater: upTo(total - plus) };
    }
    let ties = 0;
    counts.forEach(function (t) { ties += t * t * t - t; });
    const z = (plus - total / 2) / Math.sqrt(n * (n + 1) * (2 * n + 1) / 24 - ties / 48);
    const tail = normalTail(Math.abs(z)) / 2;
    return z < 0 ? { less: tail, greater: 1 - tail } : { less: 1 - tail, greater: tail };
  }
  // errors, times: rows of problems, columns of methods; errors null where there is none, lists hold single seeds.
  function board(methods, errors, times, ships, budget, criterion) {
    const late = function (i, j) { return times[i][j] !== null && times[i][j] > budget; };
    const number = function (e) { return e === null ? null : e === -1 ? Infinity : e; };
    const runs = errors.map(function (row, i) {
      return row.map(function (cell, j) {
        const own = cell === null ? [] : (Array.isArray(cell) ? cell : [cell]).map(number);
        return late(i, j) ? own.map(function (e) { return e === null ? null : Infinity; }) : own;
      });
    });
    const medians = runs.map(function (row) {
      return row.map(function (own) { const m = median(own); return isNaN(m) ? null : m; });
    });
    return { methods: methods, runs: runs, errors: medians, times: times, ships: ships, criterion: criterion };
  }
  function order(b) {
    const sums = b.methods.map(function () { return { rank: 0, problems: 0, imputed: 0 }; });
    b.errors.forEach(function (row) {
      const known = row.map(function (e, j) { return e === null ? -1 : j; }).filter(function (j) { return j >= 0; });
      if (known.length < 2) return;
      averageRanks(known.map(function (j) { return row[j]; })).forEach(function (rank, k) {
        const own = sums[known[k]];
        own.rank += rank; own.problems += 1; own.imputed += row[known[k]] === Infinity ? 1 : 0;
      });
    });
    const most = Math.max(0, ...sums.map(function (own) { return own.problems; }));
    const places = [];
    sums.forEach(function (own, i) {
      if (own.problems) places.push({ method: b.methods[i], index: i, meanRank: own.rank / own.problems,
        problems: own.problems, imputed: own.imputed, partial: own.problems < COVERAGE * most });
    });
    const rounded = function (x) { return Math.round(x * 1e9); };
    return places.sort(function (a, c) {
      return a.partial - c.partial || rounded(a.meanRank) - rounded(c.meanRank) || (a.method < c.method ? -1 : 1);
    });
  }
  function samples(b, best, other) { // log ratios of the errors in independent groups, and what each is of
    const known = b.errors.map(function (_, i) { return i; }).filter(function (i) {
      return b.errors[i][best] !== null && b.errors[i][other] !== null;
    });
    const byShip = new Map();
    known.forEach(function (i) {
      const ship = b.ships[i], own = byShip.get(ship) || [];
      own.push(logRatio(b.errors[i][other], b.errors[i][best])); byShip.set(ship, own);
    });
    const groups = Array.from(byShip.values());
    if (groups.length >= LEAST) return { unit: "ships", groups: [groups.map(function (own) { const m = median(own); return isNaN(m) ? 0 : m; })] };
    if (known.length !== 1) return { unit: "problems", groups: groups };
    const seeds = [];
    b.runs[known[0]][best].forEach(function (e, s) {
      const own = b.runs[known[0]][other][s];
      if (e !== null && own !== null && own !== undefined) seeds.push(logRatio(own, e));
    });
    return { unit: "seeds of one problem", groups: [seeds] };
  }
  function shownRatio(b, best, other) {
    const both = b.errors.filter(function (row) { return row[best] !== null && row[other] !== null; });
    const middle = function (j) { return median(both.map(function (row) { return row[j]; })); };
    return Math.exp(logRatio(middle(other), middle(best)));
  }
  function against(b, best, other) {
    const found = samples(b, best, other), values = found.groups.flat(), ratio = Math.exp(median(values));
    let verdict = FEW, p = null;
    if (found.groups.length && found.groups.every(function (own) { return own.length >= LEAST; })) {
      const tests = found.groups.map(function (own) { return signedRank(own.map(function (x) { return x - Math.log(NEAR); })); });
      const less = Math.max(...tests.map(function (t) { return t.less; })), more = Math.max(...tests.map(function (t) { return t.greater; }));
      verdict = more < LEVEL ? WORSE : less < LEVEL ? EQUAL : OPEN;
      p = verdict === WORSE ? more : less;
    }
    if (verdict === EQUAL && !(Math.max(ratio, shownRatio(b, best, other)) <= NEAR)) verdict = OPEN;
    const speeds = b.times.map(function (row) { return row[best] > 0 && row[other] > 0 ? row[best] / row[other] : null; });
    return { method: b.methods[other], index: other, errorRatio: ratio, verdict: verdict, p: p, speed: median(speeds),
      size: values.length, sample: values.length + " " + (values.length === 1 ? SINGLE[found.unit] : found.unit),
      leastP: found.groups.length ? Math.max(...found.groups.map(function (own) { return Math.pow(0.5, own.length); })) : 1 };
  }
  function rivals(b, places) {
    const full = places.filter(function (place) { return !place.partial; });
    return full.slice(1).map(function (place) { return against(b, full[0].index, place.index); });
  }
  function number(value) {
    if (!isFinite(value)) return value > 0 ? "infinitely many" : "unknown";
    const parts = value.toExponential(1).split("e"), power = Number(parts[1]);
    if (power < -4 || power > 6) return parts[0] + "e" + power;
    return (Number(parts[0]) * Math.pow(10, power)).toFixed(Math.max(0, 1 - power));
  }
  function pText(value) { return value < 0.001 ? "< 0.001" : "= " + value.toFixed(value >= 0.01 ? 2 : 3); }
  function quickest(others) {
    const speed = function (other) { return Math.round(other.speed * 1e9); };
    return others.reduce(function (a, c) { return speed(c) > speed(a) ? c : a; });
  }
  function fastChoice(best, good) {
    const fast = quickest(good);
    if (!(fast.speed >= FASTER)) return best + " itself";
    return fast.method + ", " + number(fast.speed) + " times as fast with " + number(fast.errorRatio) + " times the error";
  }
  function others(best, rest) {
    const good = rest.filter(function (other) { return other.verdict === EQUAL; });
    if (good.length) {
      const named = good.slice(0, NAMED).map(function (other) { return other.method; }).join(", ");
      return "; as good (error below " + NEAR + " times, " + sampled(good[0]) + "): " + named +
        (good.length > NAMED ? " and " + (good.length - NAMED) + " more" : "") + "; fast choice: " + fastChoice(best, good);
    }
    const least = rest.reduce(function (a, c) { return Math.round(c.errorRatio * 1e9) < Math.round(a.errorRatio * 1e9) ? c : a; });
    const near = least.method + " errs " + number(least.errorRatio) + " times as much";
    if (rest.every(function (other) { return other.verdict === FEW; })) {
      const most = rest.reduce(function (a, c) { return c.size > a.size ? c : a; });
      return "; too few problems (" + most.sample + ") to say which are as good; the nearest, " + near;
    }
    if (least.verdict === WORSE) return "; no other is as good: the nearest, " + near + " (" + sampled(least) + ")";
    return "; none is shown to be as good, and it is not settled: " + near + " (" + sampled(least) + ")";
  }
  function sampled(other) { return other.sample + ", with which p is " + number(other.leastP) + " at the least"; }
  function counted(count, word) { return count + " " + word + (count === 1 ? "" : "s"); }
  function problems(b, method) {
    const known = b.errors.map(function (_, i) { return i; }).filter(function (i) { return b.errors[i][method] !== null; });
    return counted(known.length, "problem") + " of " + counted(new Set(known.map(function (i) { return b.ships[i]; })).size, "ship");
  }
  function littleSkill(b, best) { // against what an error is no great one
    if (FLOORS.includes(b.methods[best])) return ", which identifies nothing";
    let least = { error: Infinity, name: "", own: 0 };
    FLOORS.forEach(function (name) {
      const floor = b.methods.indexOf(name);
      if (floor < 0) return;
      const both = b.errors.filter(function (row) { return row[floor] !== null && row[best] !== null; });
      const error = median(both.map(function (row) { return row[floor]; }));
      if (error < least.error) least = { error: error, name: name, own: median(both.map(function (row) { return row[best]; })) };
    });
    return least.own > LITTLE * least.error ? ", which is little skill: " + least.name + ", without any identification, errs " + number(least.error) : "";
  }
  function answer(b, places, rest) {
    const full = places.filter(function (place) { return !place.partial; });
    if (!full.length) return NOTHING;
    const best = full[0].index;
    const error = median(b.errors.map(function (row) { return row[best]; }));
    const seconds = median(b.times.map(function (row) { return row[best]; }));
    if (!isFinite(error)) return "No method predicts these problems with a finite error.";
    const useless = error >= MEAN && b.criterion === "prediction"
      ? "None predicts better than the mean of the record (error 1); least bad: " : "";
    return useless + full[0].method + " (error " + number(error) + ", " + number(seconds) + " s; " + problems(b, best) + ")" +
      (useless || b.criterion !== "prediction" ? "" : littleSkill(b, best)) + (rest.length ? others(full[0].method, rest) : "") + "." +
      (b.criterion === "prediction" ? listed(b, full) : "");
  }
  function covering(good) { // at most SHORT columns that together are true in many rows; a row counts a quarter each time it is covered
    const chosen = [0];
    let weights = good.map(function () { return 1; });
    while (chosen.length < Math.min(SHORT, good[0].length)) {
      const latest = chosen[chosen.length - 1];
      weights = weights.map(function (w, i) { return good[i][latest] ? 0.25 * w : w; });
      const gains = good[0].map(function (_, j) {
        return chosen.includes(j) ? -1 : good.reduce(function (sum, row, i) { return sum + (row[j] ? weights[i] : 0); }, 0);
      });
      chosen.push(gains.indexOf(Math.max(...gains)));
    }
    return chosen;
  }
  function shortlist(b, full) { // a few methods of which one is good in most problems, and what such a list is worth on a ship left out
    const raised = b.errors.map(function (row) { return row.map(function (e) { return e === null ? Infinity : Math.max(e, FLOOR); }); });
    const kept = raised.map(function (_, i) { return i; }).filter(function (i) {
      return Math.min(...raised[i]) < MEAN && b.errors[i].filter(function (e) { return e !== null; }).length > 1;
    });
    if (!kept.length) return { names: [full[0].method], share: NaN, count: 0 };
    const good = kept.map(function (i) {
      const least = Math.min(...raised[i]);
      return full.map(function (place) { return raised[i][place.index] < GOOD * least; });
    });
    const each = new Set(kept.map(function (i) { return b.ships[i]; })), hits = [];
    each.forEach(function (ship) {
      const own = good.filter(function (_, k) { return b.ships[kept[k]] === ship; });
      const chosen = covering(each.size > 1 ? good.filter(function (_, k) { return b.ships[kept[k]] !== ship; }) : good);
      own.forEach(function (row) {
        hits.push(chosen.map(function (_, n) { return chosen.slice(0, n + 1).some(function (j) { return row[j]; }); }));
      });
    });
    const shares = hits[0].map(function (_, n) { return hits.filter(function (row) { return row[n]; }).length / hits.length; });
    const capped = shares.map(function (share) { return Math.min(share, ENOUGH); }), last = capped.indexOf(Math.max(...capped));
    return { names: covering(good).slice(0, last + 1).map(function (j) { return full[j].method; }),
      share: each.size > 1 ? shares[last] : NaN, count: good.length };
  }
  function listed(b, full) {
    const found = shortlist(b, full);
    if (found.names.length < 2) return "";
    const told = " Compare " + found.names.join(", ") + " on a record kept back";
    return isNaN(found.share) ? told + "." : told + ": of a list made without the ship, one errs less than " + GOOD + " times the least in " +
      percent(found.share) + " of " + found.count + " problems.";
  }
  function percent(share) { // half to even, as Python rounds
    const x = share * 100, low = Math.floor(x), rest = x - low;
    return (rest > 0.5 || (rest === 0.5 && low % 2) ? low + 1 : low) + " %";
  }
  return { median: median, signedRank: signedRank, board: board, order: order, rivals: rivals, answer: answer,
    number: number, pText: pText, NOTHING: NOTHING };
})();
