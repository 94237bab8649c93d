// Ranks, tests and the answer, as reporting/leaderboard/contest.py, paired.py and answer.py compute them.
"use strict";
const Ranking = (function () {
  const COVERAGE = 0.9, LEVEL = 0.05, LEAST_PAIRS = 6, NEAR = 1.25, FASTER = 1.2, EXACT_PAIRS = 50;

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
  function signedRank(first, second) {
    const d = first.map(function (a, i) { return logRatio(a, second[i]); })
      .filter(function (x) { return Math.abs(x) > 1e-12; });
    const n = d.length;
    if (!n) return 1;
    const size = d.map(function (x) { return Math.round(Math.abs(x) * 1e9) / 1e9; });
    const ranks = averageRanks(size), counts = new Map();
    size.forEach(function (x) { counts.set(x, (counts.get(x) || 0) + 1); });
    let plus = 0;
    d.forEach(function (x, i) { if (x > 0) plus += ranks[i]; });
    const total = n * (n + 1) / 2, least = Math.min(plus, total - plus);
    if (n <= EXACT_PAIRS && counts.size === n) {
      let ways = [1];
      for (let k = 1; k <= n; k++) {
        const next = new Array(ways.length + k).fill(0);
        ways.forEach(function (w, i) { next[i] += w; next[i + k] += w; });
        ways = next;
      }
      let below = 0;
      for (let i = 0; i <= least; i++) below += ways[i];
      return Math.min(1, 2 * below / Math.pow(2, n));
    }
    let ties = 0;
    counts.forEach(function (t) { ties += t * t * t - t; });
    const variance = n * (n + 1) * (2 * n + 1) / 24 - ties / 48;
    return normalTail(Math.abs(plus - total / 2) / Math.sqrt(variance));
  }
  function holm(p) {
    const order = p.map(function (_, i) { return i; }).sort(function (a, b) { return p[a] - p[b]; });
    const adjusted = new Array(p.length);
    let most = 0;
    order.forEach(function (i, place) { most = Math.max(most, p[i] * (p.length - place)); adjusted[i] = Math.min(1, most); });
    return adjusted;
  }
  // errors, times: rows of problems, columns of methods; errors null where there is none, lists hold single seeds.
  function board(methods, errors, times, budget, criterion) {
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
    return { methods: methods, runs: runs, errors: medians, times: times, criterion: criterion };
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
  function paired(b, best, other) {
    const first = [], second = [];
    b.errors.forEach(function (row) {
      if (row[best] !== null && row[other] !== null) { first.push(row[best]); second.push(row[other]); }
    });
    if (first.length >= LEAST_PAIRS) return [first, second];
    const one = [], two = [];
    b.runs.forEach(function (row) {
      row[best].forEach(function (e, s) {
        const own = row[other][s];
        if (e !== null && own !== null && own !== undefined) { one.push(e); two.push(own); }
      });
    });
    return [one, two];
  }
  function rivals(b, places) {
    const full = places.filter(function (place) { return !place.partial; });
    const pairs = full.slice(1).map(function (place) { return paired(b, full[0].index, place.index); });
    const p = holm(pairs.map(function (own) { return signedRank(own[1], own[0]); }));
    return full.slice(1).map(function (place, i) {
      const ratios = pairs[i][1].map(function (e, k) { return logRatio(e, pairs[i][0][k]); });
      const speeds = b.times.map(function (row) {
        const t = row[full[0].index], own = row[place.index];
        return t > 0 && own > 0 ? t / own : null;
      });
      return { method: place.method, index: place.index, p: p[i], errorRatio: Math.exp(median(ratios)),
        speed: median(speeds), pairs: pairs[i][0].length };
    });
  }
  function number(value) {
    if (!isFinite(value)) return value > 0 ? "infinitely many" : "unknown";
    const parts = value.toExponential(1).split("e"), power = Number(parts[1]);
    if (power < -4 || power > 6) return parts[0] + "e" + power;
    return (Number(parts[0]) * Math.pow(10, power)).toFixed(Math.max(0, 1 - power));
  }
  function pText(value) { return value < 0.001 ? "< 0.001" : "= " + value.toFixed(value >= 0.01 ? 2 : 3); }
  function faster(other) {
    if (other.speed >= FASTER) return " and " + number(other.speed) + " times as fast";
    return other.speed <= 1 / FASTER ? " but " + number(1 / other.speed) + " times as slow" : "";
  }
  function quickest(others) {
    const speed = function (other) { return Math.round(other.speed * 1e9); };
    return others.reduce(function (a, c) { return speed(c) > speed(a) ? c : a; });
  }
  function answer(b, places, others) {
    const full = places.filter(function (place) { return !place.partial; });
    if (!full.length) return "No two methods were compared under these conditions.";
    const best = full[0].index;
    const error = median(b.errors.map(function (row) { return row[best]; }));
    const seconds = median(b.times.map(function (row) { return row[best]; }));
    if (!isFinite(error)) return "No method predicts these problems with a finite error.";
    const useless = error >= 1 && b.criterion === "prediction"
      ? "None predicts better than the mean of the record (error 1); least bad: " : "";
    const head = useless + full[0].method + " (error " + number(error) + ", " + number(seconds) + " s)";
    const pairs = Math.max(0, ...others.map(function (other) { return other.pairs; }));
    const near = others.filter(function (other) { return other.errorRatio <= NEAR; });
    if (pairs < LEAST_PAIRS) {
      const quick = near.filter(function (other) { return other.speed >= FASTER; });
      const fast = quick.length ? quickest(quick) : null;
      return head + "; " + (pairs === 1 ? "1 paired run is" : pairs + " paired runs are") + " too few for a test" + (fast
        ? "; " + fast.method + " errs " + number(fast.errorRatio) + " times as much and is " + number(fast.speed) + " times as fast"
        : "") + ".";
    }
    const good = near.filter(function (other) { return other.p >= LEVEL; });
    if (!good.length) {
      const least = others.reduce(function (a, c) {
        return Math.round(c.errorRatio * 1e9) < Math.round(a.errorRatio * 1e9) ? c : a;
      });
      const told = least.method + " errs " + number(least.errorRatio) + " times as much";
      if (least.p >= LEVEL) return head + "; " + told + ", but no test tells the two apart (p " + pText(least.p) + ").";
      return head + "; no other is as good: " + told + " (p " + pText(least.p) + ").";
    }
    const fast = quickest(good), chosen = fast.speed >= FASTER ? fast : good[0];
    const more = good.length > 1 ? "; " + (good.length - 1) + (good.length === 2 ? " more is" : " more are") + " as good" : "";
    return head + "; " + chosen.method + " is as good (p " + pText(chosen.p) + ")" + faster(chosen) + more + ".";
  }
  return { median: median, signedRank: signedRank, holm: holm, board: board, order: order, rivals: rivals, answer: answer,
    number: number, pText: pText };
})();
