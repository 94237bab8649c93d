// The selector, its answer, the ranking and the plot of error against time.
"use strict";
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const form = document.getElementById("chooser"), dims = data.dimensions;
  const state = { chosen: {}, budget: "", criterion: "prediction", sort: "", way: 1, method: "", problem: "" };
  const make = Drawing.make;

  function fits(i, except) {
    return dims.every(function (dim) {
      const own = state.chosen[dim.name];
      return dim.name === except || own === undefined || dim.levels[dim.of[i]] === own;
    });
  }
  function chosenProblems() { return data.problems.map(function (_, i) { return i; }).filter(function (i) { return fits(i, ""); }); }

  function addSelect(name, title, options, change) {
    const label = make("label", {}, form), select = make("select", { name: name, id: "choose-" + name }, label);
    label.prepend(make("span", { text: title }));
    options.forEach(function (option) { make("option", { value: option[0], text: option[1] }, select); });
    select.addEventListener("change", function () { change(select.value); show(); });
    return select;
  }
  function buildForm() {
    dims.forEach(function (dim) {
      const options = [["", "any"]].concat(dim.levels.map(function (level, i) { return [level, dim.titles[i]]; }));
      addSelect(dim.name, dim.title, options, function (value) {
        if (value) state.chosen[dim.name] = value; else delete state.chosen[dim.name];
      });
    });
    const budgets = Object.keys(data.budgets);
    if (budgets.length) addSelect("budget", "CPU time for a fit", [["", "any"]].concat(budgets.map(function (text) {
      return [text, "at most " + text];
    })), function (value) { state.budget = value; });
    const names = { prediction: "prediction", parameters: "parameters" };
    if (Object.keys(data.errors).length > 1) addSelect("criterion", "ranked by error of", Object.keys(data.errors).map(
      function (name) { return [name, names[name]]; }), function (value) { state.criterion = value; });
    make("button", { type: "button", text: "Reset" }, form).addEventListener("click", function () {
      state.chosen = Object.assign({}, data.begin); state.budget = ""; state.criterion = Object.keys(data.errors)[0]; state.method = ""; show();
    });
  }
  function showForm() {
    dims.forEach(function (dim) {
      const select = form.elements[dim.name], possible = new Set();
      data.problems.forEach(function (_, i) { if (fits(i, dim.name)) possible.add(dim.levels[dim.of[i]]); });
      Array.from(select.options).forEach(function (option) {
        option.disabled = option.value !== "" && !possible.has(option.value);
      });
      select.value = state.chosen[dim.name] || "";
    });
    if (form.elements.budget) form.elements.budget.value = state.budget;
    if (form.elements.criterion) form.elements.criterion.value = state.criterion;
  }

  function interval(values) { // of the median, from order statistics at 95 %
    const v = values.filter(function (x) { return x !== null; }).sort(function (a, b) { return a - b; });
    const middle = (v.length - 1) / 2, half = 0.98 * Math.sqrt(v.length);
    return [v[Math.max(0, Math.floor(middle - half))], v[Math.min(v.length - 1, Math.ceil(middle + half))]];
  }
  function text(value) { return value === Infinity ? "∞" : value === null || isNaN(value) ? "–" : Ranking.number(value); }
  function seconds(value) {
    if (value === null || isNaN(value)) return "–";
    return value >= 0.995 ? Ranking.number(value) + " s" : Ranking.number(value * 1000) + " ms";
  }

  function rowsOf(problems, board, places, others) {
    const of = new Map(others.map(function (other) { return [other.index, other]; }));
    return places.map(function (place, i) {
      const j = place.index, errors = board.errors.map(function (row) { return row[j]; });
      const sum = function (part) {
        return problems.reduce(function (total, k) { return total + part(data.counts[k][j]); }, 0);
      };
      return { place: i + 1, method: place.method, index: j, rank: place.meanRank, error: Ranking.median(errors),
        interval: interval(errors), problems: place.problems, partial: place.partial, imputed: place.imputed,
        failed: sum(function (c) { return c % 1000; }), diverged: sum(function (c) { return Math.floor(c / 1000) % 1000; }),
        absent: sum(function (c) { return Math.floor(c / 1e6); }),
        time: Ranking.median(board.times.map(function (row) { return row[j]; })), verdict: of.has(j) ? of.get(j).verdict : "", p: of.has(j) ? of.get(j).p : null };
    });
  }
  const columns = [
    ["place", "place", function (r) { return String(r.place); }, ""],
    ["method", "method", null, ""],
    ["rank", "mean rank", function (r) { return r.rank.toFixed(2); }, "mean over the problems of the rank among the methods compared there"],
    ["error", "error [95 %]", function (r) { return text(r.error) + " [" + text(r.interval[0]) + ", " + text(r.interval[1]) + "]"; }, "median over the problems"],
    ["verdict", "against the first", function (r) { return r.verdict + (r.p === null ? "" : " (p " + Ranking.pText(r.p) + ")") || "–"; },
      "as good: its error is shown to be below 1.25 times that of the first; worse: above; one-sided signed-rank tests, each ship counts once; only within one case of what is known"],
    ["problems", "problems", function (r) { return String(r.problems); }, "problems in which the method was compared"],
    ["imputed", "without an error", function (r) { return r.imputed ? r.imputed + " ranked last" : "0"; }, "problems in which it failed, diverged or took too long: it ranks last there"],
    ["failed", "failed runs", function (r) { return String(r.failed); }, ""],
    ["diverged", "diverged runs", function (r) { return String(r.diverged); }, ""],
    ["absent", "not applicable", function (r) { return String(r.absent); }, "runs; not ranked"],
    ["time", "CPU time of a fit", function (r) { return seconds(r.time); }, "median over the problems"],
  ];
  function named(node, name) { // a name breaks only after its colons and commas
    name.split(/(?<=[:,])/).forEach(function (part, i) {
      if (i) make("wbr", {}, node);
      node.appendChild(document.createTextNode(part));
    });
    return node;
  }
  let shown = [];
  function showTable() {
    const head = document.querySelector("#ranking thead tr"), body = document.querySelector("#ranking tbody");
    if (!head.children.length) columns.forEach(function (column) {
      const th = make("th", { scope: "col", class: column[0] === "method" ? "" : "number" }, head);
      const button = make("button", { type: "button", text: column[1], title: column[3] }, th);
      th.dataset.name = column[0];
      button.addEventListener("click", function () {
        const same = (state.sort || "place") === column[0];
        state.way = same ? -state.way : 1; state.sort = column[0] === "place" ? "" : column[0]; show();
      });
    });
    const key = state.sort || "place";
    Array.from(head.children).forEach(function (th) {
      if (th.dataset.name === key) th.setAttribute("aria-sort", state.way > 0 ? "ascending" : "descending");
      else th.removeAttribute("aria-sort");
    });
    const rows = shown.slice().sort(function (a, b) {
      const x = a[key], y = b[key];
      if (x === null || y === null) return (x === null) - (y === null);
      return state.way * (x < y ? -1 : x > y ? 1 : 0) || a.place - b.place;
    });
    body.textContent = "";
    rows.forEach(function (row, n) {
      const kind = row.method === state.method ? "chosen" : row.partial ? "partial" : "";
      const tr = make("tr", { class: kind }, body);
      if (!state.sort && state.way > 0 && row.partial && (n === 0 || !rows[n - 1].partial)) {
        const line = make("tr", { class: "rule" });
        make("td", { colspan: columns.length, text: "Compared on fewer than 90 % of these problems:" }, line);
        body.insertBefore(line, tr);
      }
      columns.forEach(function (column) {
        if (column[0] === "method") {
          const th = make("th", { scope: "row" }, tr);
          named(make("button", { type: "button", title: "show its runs" }, th), row.method).addEventListener("click", function () {
            state.method = row.method; state.problem = ""; show();
            document.getElementById("runs").scrollIntoView(); document.getElementById("run-title").focus();
          });
        } else make("td", { class: "number", text: column[2](row) }, tr);
      });
    });
  }
  function csv() {
    const names = ["place", "method", "rank", "error", "low", "high", "verdict", "p", "problems", "imputed", "failed", "diverged", "absent", "time"];
    const cell = function (value) {
      return value === null || value === undefined ? "" : typeof value === "string" ? '"' + value.replace(/"/g, '""') + '"' : String(value);
    };
    return [names.join(",")].concat(shown.map(function (r) {
      return [r.place, r.method, r.rank, r.error, r.interval[0], r.interval[1], r.verdict, r.p, r.problems, r.imputed, r.failed,
        r.diverged, r.absent, r.time].map(cell).join(",");
    })).join("\n") + "\n";
  }
  function plot() {
    const points = shown.filter(function (r) { return !isNaN(r.time) && r.time > 0; }).map(function (r) {
      return { x: r.time, y: r.error, name: r.method, strong: r.place === 1 };
    });
    let least = Infinity;
    points.slice().sort(function (a, b) { return a.x - b.x || a.y - b.y; }).forEach(function (point) {
      point.front = point.y < least; least = Math.min(least, point.y);
    });
    Drawing.scatter(document.getElementById("front"), points, "median CPU time of a fit (s)", "median error (-)");
  }

  function writeHash() {
    const parts = new URLSearchParams(state.chosen);
    Object.keys(data.begin).forEach(function (name) {
      if (!state.chosen[name]) parts.set(name, ""); else if (state.chosen[name] === data.begin[name]) parts.delete(name);
    });
    ["budget", "sort", "method", "problem"].forEach(function (name) { if (state[name]) parts.set("_" + name, state[name]); });
    if (state.criterion !== Object.keys(data.errors)[0]) parts.set("_criterion", state.criterion);
    if (state.way < 0) parts.set("_way", "-1");
    const hash = parts.toString();
    history.replaceState(null, "", hash ? "#" + hash : location.pathname + location.search);
  }
  function readHash() {
    const parts = new URLSearchParams(location.hash.slice(1));
    state.chosen = {};
    dims.forEach(function (dim) { const own = parts.has(dim.name) ? parts.get(dim.name) : data.begin[dim.name]; if (dim.levels.includes(own)) state.chosen[dim.name] = own; });
    state.budget = data.budgets[parts.get("_budget")] ? parts.get("_budget") : "";
    state.criterion = data.errors[parts.get("_criterion")] ? parts.get("_criterion") : Object.keys(data.errors)[0];
    state.sort = parts.get("_sort") || ""; state.way = parts.get("_way") === "-1" ? -1 : 1;
    if (!columns.some(function (column) { return column[0] === state.sort; })) state.sort = "";
    state.method = data.methods.includes(parts.get("_method")) ? parts.get("_method") : "";
    state.problem = parts.get("_problem") || "";
  }

  function boardOf(problems) {
    const pick = function (rows) { return problems.map(function (i) { return rows[i]; }); };
    return Ranking.board(data.methods, pick(data.errors[state.criterion]), pick(data.times), problems.map(function (i) { return data.problems[i][0]; }),
      data.budgets[state.budget] || Infinity, state.criterion);
  }
  function headlines(problems) { // a line for every case of what is known: they are never put together
    const found = [];
    data.cases.forEach(function (name, c) {
      const own = problems.filter(function (i) { return data.caseOf[i] === c; });
      if (!own.length) return;
      const board = boardOf(own), places = Ranking.order(board), others = Ranking.rivals(board, places);
      found.push({ name: name, text: Ranking.answer(board, places, others), others: others });
    });
    return found;
  }
  function showAnswer(lines) {
    const place = document.getElementById("answer"), several = lines.length > 1;
    place.textContent = lines.length ? "" : Ranking.NOTHING;
    lines.forEach(function (line) {
      const row = make("span", {}, place);
      const parts = line.text.split(/(?<=\.)(?= Compare )/);
      unbroken(row, (several ? line.name[0].toUpperCase() + line.name.slice(1) + ": " : "") + parts[0]);
      if (parts.length > 1) unbroken(make("small", {}, row), parts[1]);
    });
  }
  const names = new RegExp("(" + data.methods.slice().sort(function (a, b) { return b.length - a.length; }).map(function (name) {
    return name.replace(/[^\w]/g, "\\$&");
  }).join("|") + ")");
  function unbroken(node, text) { // the text, in which no name of a method breaks
    text.split(names).forEach(function (part, i) {
      if (i % 2) make("b", { text: part }, node); else node.appendChild(document.createTextNode(part));
    });
  }
  function show() {
    const problems = chosenProblems(), board = boardOf(problems), places = Ranking.order(board);
    const begun = !state.budget && JSON.stringify(state.chosen) === JSON.stringify(data.begin);
    const lines = headlines(begun ? problems.concat(data.elsewhere) : problems), others = lines.length === 1 ? lines[0].others : [];
    showForm();
    showAnswer(lines);
    const seeds = Math.max(1, ...board.runs.map(function (row) { return Math.max(...row.map(function (own) { return own.length; })); }));
    document.getElementById("basis").textContent = problems.length + (problems.length === 1 ? " problem, " : " problems, ") +
      places.length + " methods" + (seeds > 1 ? ", up to " + seeds + " seeds each" : "") + ".";
    shown = rowsOf(problems, board, places, others);
    showTable();
    plot();
    Runs.show(data, board, problems, state, show);
    writeHash();
  }

  buildForm();
  readHash();
  show();
  window.addEventListener("hashchange", function () { readHash(); show(); });
  document.getElementById("csv").addEventListener("click", function () { Drawing.download("ranking.csv", "text/csv", csv()); });
})();
