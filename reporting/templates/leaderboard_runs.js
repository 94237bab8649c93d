// Drawings, and the view of one run: curves, residuals, track and estimates.
"use strict";
const Drawing = (function () {
  const SVG = "http://www.w3.org/2000/svg";
  function make(name, attributes, parent) {
    const node = document.createElement(name);
    return dressed(node, attributes, parent);
  }
  function draw(name, attributes, parent) { return dressed(document.createElementNS(SVG, name), attributes, parent); }
  function dressed(node, attributes, parent) {
    Object.entries(attributes || {}).forEach(function (own) {
      if (own[0] === "text") node.textContent = own[1];
      else if (own[1] !== "" || own[0] === "value") node.setAttribute(own[0], own[1]);
    });
    if (parent) parent.appendChild(node);
    return node;
  }
  function download(name, type, content) {
    const link = make("a", { href: URL.createObjectURL(new Blob([content], { type: type })), download: name });
    link.click();
    setTimeout(function () { URL.revokeObjectURL(link.href); }, 1000);
  }
  function standalone(svg) { // the colours of the page written into a copy
    const copy = svg.cloneNode(true), style = getComputedStyle(document.documentElement);
    copy.setAttribute("xmlns", SVG);
    const names = ["--ink", "--soft", "--line", "--accent", "--warn", "--page"];
    const colours = names.map(function (name) { return name + ":" + style.getPropertyValue(name).trim(); }).join(";");
    const rules = document.getElementById("drawing-style").textContent;
    copy.prepend(draw("style", { text: "svg{" + colours + ";background:var(--page)}" + rules }));
    return new XMLSerializer().serializeToString(copy);
  }
  function saveButton(figure, svg, name) {
    make("button", { type: "button", class: "save", text: "SVG", "aria-label": "download " + name + " as SVG" }, figure)
      .addEventListener("click", function () { download(name + ".svg", "image/svg+xml", standalone(svg)); });
  }
  function nice(low, high, count) {
    const raw = (high - low) / count || 1, power = Math.pow(10, Math.floor(Math.log10(raw)));
    const step = [1, 2, 5, 10].map(function (k) { return k * power; }).find(function (s) { return s >= raw; });
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
    return found;
  }
  function tick(value) {
    const size = Math.abs(value);
    return size && (size < 1e-3 || size >= 1e5) ? value.toExponential(0) : String(Number(value.toPrecision(6)));
  }
  function room(parent) { return Math.round(Math.min(640, Math.max(300, parent.clientWidth - 20))); } // texts keep their size
  // frame: {width, height, x: [low, high], y: [low, high], logX, logY, xTitle, yTitle}
  function axes(figure, frame, label) {
    const left = 62, right = 14, top = 10, bottom = 42, w = frame.width, h = frame.height;
    const svg = draw("svg", { viewBox: "0 0 " + w + " " + h, role: "img", "aria-label": label, class: "drawn" }, figure);
    const place = function (value, range, log, from, to) {
      const f = log ? Math.log10 : Number;
      return from + (f(value) - f(range[0])) / ((f(range[1]) - f(range[0])) || 1) * (to - from);
    };
    const x = function (v) { return place(v, frame.x, frame.logX, left, w - right); };
    const y = function (v) { return place(v, frame.y, frame.logY, h - bottom, top); };
    const ticks = function (range, log, count) {
      if (!log) return nice(range[0], range[1], count);
      const a = Math.ceil(Math.log10(range[0]) - 1e-9), b = Math.floor(Math.log10(range[1]) + 1e-9);
      const step = Math.max(1, Math.ceil((b - a) / 6)), found = [];
      if (b - a < 1) {
        for (let k = a - 1; k <= b; k++) [1, 2, 5].forEach(function (m) {
          const v = m * Math.pow(10, k);
          if (v >= range[0] && v <= range[1]) found.push(v);
        });
        return found;
      }
      for (let k = a; k <= b; k += step) found.push(Math.pow(10, k));
      return found;
    };
    ticks(frame.x, frame.logX, 6).forEach(function (v) {
      draw("line", { class: "grid", x1: x(v), x2: x(v), y1: top, y2: h - bottom }, svg);
      draw("text", { class: "tick", x: x(v), y: h - bottom + 15, "text-anchor": "middle", text: tick(v) }, svg);
    });
    ticks(frame.y, frame.logY, 4).forEach(function (v) {
      draw("line", { class: "grid", x1: left, x2: w - right, y1: y(v), y2: y(v) }, svg);
      draw("text", { class: "tick", x: left - 6, y: y(v) + 4, "text-anchor": "end", text: tick(v) }, svg);
    });
    draw("text", { class: "axis", x: (left + w - right) / 2, y: h - 8, "text-anchor": "middle", text: frame.xTitle }, svg);
    draw("text", { class: "axis", x: 0, y: 0, transform: "translate(14 " + (top + h - bottom) / 2 + ") rotate(-90)",
      "text-anchor": "middle", text: frame.yTitle }, svg);
    return { svg: svg, x: x, y: y, left: left, right: w - right, top: top, bottom: h - bottom };
  }
  function line(plot, xs, ys, name) {
    let path = "", pen = false;
    xs.forEach(function (v, i) {
      const known = v !== null && ys[i] !== null;
      if (known) path += (pen ? "L" : "M") + plot.x(v).toFixed(1) + " " + plot.y(ys[i]).toFixed(1);
      pen = known;
    });
    draw("path", { class: "curve " + name, d: path }, plot.svg);
  }
  function scatter(figure, points, xTitle, yTitle) {
    figure.textContent = "";
    if (!points.length) return;
    const finite = points.filter(function (p) { return isFinite(p.y); }), xs = points.map(function (p) { return p.x; });
    const ys = finite.map(function (p) { return Math.max(p.y, 1e-6); });
    const low = Math.min(...ys, 1), high = Math.max(...ys, ys.length ? 0 : 1), lost = points.length > finite.length;
    const frame = { width: room(figure), height: 340, logX: true, logY: true, xTitle: xTitle, yTitle: yTitle,
      x: [Math.min(...xs) / 1.6, Math.max(...xs) * 4], y: [low / 1.6, high * (lost ? 6 : 1.6)] };
    const plot = axes(figure, frame, "Median error of every method against its median time");
    const front = points.filter(function (p) { return p.front && isFinite(p.y); }).sort(function (a, b) { return a.x - b.x; });
    line(plot, front.map(function (p) { return p.x; }), front.map(function (p) { return Math.max(p.y, 1e-6); }), "front");
    if (lost) draw("text", { class: "tick", x: plot.left + 4, y: plot.top + 24, text: "▲ infinite: most problems without an error" }, plot.svg);
    const around = function (p) {
      const cx = plot.x(p.x), cy = plot.y(Math.max(p.y, 1e-6));
      return [cx - 5, cy - 5, cx + 5, cy + 5];
    };
    const named = function (p) { return p.front || p.strong; }, boxes = finite.filter(named).map(around);
    const others = finite.filter(function (p) { return !named(p); }).map(around);
    points.slice().sort(function (a, b) { return (named(b) ? 1 : 0) - (named(a) ? 1 : 0); }).forEach(function (p) {
      const cx = plot.x(p.x), inf = !isFinite(p.y), cy = inf ? plot.top + 6 : plot.y(Math.max(p.y, 1e-6));
      const kind = p.strong ? "dot strong" : p.front ? "dot on" : "dot";
      const shape = inf ? draw("path", { class: kind, d: "M" + (cx - 5) + " " + (cy + 4) + "h10l-5 -9z" }, plot.svg)
        : p.y <= 1e-6 ? draw("rect", { class: kind, x: cx - 4, y: cy - 4, width: 8, height: 8 }, plot.svg)
        : draw("circle", { class: kind, cx: cx, cy: cy, r: p.strong ? 6 : 4.5 }, plot.svg);
      draw("title", { text: p.name + ": error " + (inf ? "infinite" : Ranking.number(p.y)) + (p.y <= 1e-6 ? " or less (square: exact)" : "") + ", " + Ranking.number(p.x) + " s" }, shape);
      if (inf || !named(p)) return;
      const wide = p.name.length * 6.4, places = [[cx + 9, cy + 4], [cx - 9 - wide, cy + 4], [cx + 4, cy - 10], [cx - wide / 2, cy + 19]]
        .map(function (at) { return [at[0], at[1] - 10, at[0] + wide, at[1] + 2]; })
        .filter(function (box) { return box[2] <= plot.right && box[0] >= plot.left && box[3] <= plot.bottom; });
      const clear = function (taken) {
        return places.find(function (box) {
          return !taken.some(function (b) { return box[0] < b[2] && b[0] < box[2] && box[1] < b[3] && b[1] < box[3]; });
        });
      };
      const free = clear(boxes.concat(others)) || clear(boxes); // rather over a dot without a name than no name
      if (free) { boxes.push(free); draw("text", { class: "name", x: free[0], y: free[3] - 2, text: p.name }, plot.svg); }
    });
    saveButton(figure, plot.svg, "error-against-time");
  }
  return { make: make, draw: draw, room: room, axes: axes, line: line, scatter: scatter, saveButton: saveButton, download: download };
})();

const Runs = (function () {
  const ALPHABET = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_", DEG = 180 / Math.PI;
  const CHANNELS = { heading_rad: ["heading", "deg", DEG], yaw_rate_rad_s: ["yaw rate", "deg/s", DEG],
    surge_m_s: ["surge velocity", "m/s", 1], sway_m_s: ["sway velocity", "m/s", 1] };
  const make = Drawing.make;
  function decoded(text, low, high) {
    const found = [];
    for (let i = 0; i < text.length; i += 2) {
      const code = ALPHABET.indexOf(text[i]) * 64 + ALPHABET.indexOf(text[i + 1]);
      found.push(code === 4095 ? null : low + (high - low) * code / 4094);
    }
    return found;
  }
  function range(lists) {
    const v = lists.flat().filter(function (x) { return x !== null; });
    const low = Math.min(...v), high = Math.max(...v), room = (high - low) * 0.05 || Math.abs(high) * 0.05 || 1e-9;
    return [low - room, high + room];
  }
  function figure(parent, caption, name, frame, curves, label) {
    const own = make("figure", {}, parent), head = make("figcaption", { text: caption }, own);
    curves.forEach(function (curve) { if (curve[3]) make("span", { class: "key " + curve[2], text: curve[3] }, head); });
    const plot = Drawing.axes(own, frame, label);
    if (frame.y[0] < 0 && frame.y[1] > 0 && frame.zero) Drawing.draw("line", { class: "zero", x1: plot.left, x2: plot.right,
      y1: plot.y(0), y2: plot.y(0) }, plot.svg);
    curves.forEach(function (curve) { Drawing.line(plot, curve[0], curve[1], curve[2]); });
    Drawing.saveButton(own, plot.svg, name);
  }
  function curves(parent, run, entry, method) {
    const t = run.time, span = range([t]), time = { width: Drawing.room(parent), height: 220, x: span, xTitle: "time (s)" };
    const channels = {};
    Object.keys(entry.curves).forEach(function (name) {
      const m = run.measured[name], r = entry.curves[name];
      const measured = decoded(m[2], m[0], m[1]), rest = decoded(r[1], -r[0], r[0]);
      const predicted = measured.map(function (v, i) { return v === null || rest[i] === null ? null : v - rest[i]; });
      channels[name] = { measured: measured, rest: rest, predicted: predicted };
    });
    Object.keys(CHANNELS).filter(function (name) { return channels[name]; }).forEach(function (name) {
      const c = channels[name], known = CHANNELS[name], to = function (list) {
        return list.map(function (v) { return v === null ? null : v * known[2]; });
      };
      const own = [to(c.measured), to(c.predicted), to(c.rest)], title = known[0] + " (" + known[1] + ")";
      figure(parent, "", known[0].replace(/ /g, "-"), Object.assign({ y: range(own.slice(0, 2)), yTitle: title }, time),
        [[t, own[0], "measured", "measured"], [t, own[1], "predicted", "predicted"]], title + " of " + method + ", measured and predicted");
      figure(parent, "", known[0].replace(/ /g, "-") + "-residual", Object.assign({ y: range([own[2], [0]]), zero: true,
        yTitle: "residual (" + known[1] + ")" }, time), [[t, own[2], "residual", "measured - predicted"]], "residual of " + title);
    });
    if (channels.north_m && channels.east_m) {
      const a = channels.east_m, b = channels.north_m, x = range([a.measured, a.predicted]), y = range([b.measured, b.predicted]);
      const across = time.width - 76, size = Math.max((x[1] - x[0]) / across, (y[1] - y[0]) / 308);
      const wide = function (r, pixels) { const mid = (r[0] + r[1]) / 2, half = size * pixels / 2; return [mid - half, mid + half]; };
      figure(parent, "track ", "track", { width: time.width, height: 360, x: wide(x, across), y: wide(y, 308), xTitle: "east (m)", yTitle: "north (m)" },
        [[a.measured, b.measured, "measured", "measured"], [a.predicted, b.predicted, "predicted", "predicted"]], "track, measured and predicted");
    }
  }
  function estimates(parent, run, entry) {
    if (!entry.estimates) return;
    const named = run.kind === "derived" ? "truth (derived by linearising)" : "truth";
    make("h3", { text: "Estimates with 95 % intervals" }, parent);
    const table = make("table", {}, make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "estimates" }, parent));
    const head = make("tr", {}, make("thead", {}, table)), body = make("tbody", {}, table);
    ["parameter", "unit", "estimate", "interval", named].forEach(function (name, i) {
      make("th", { scope: "col", class: i > 1 ? "number" : "", text: name }, head);
    });
    const f = function (v) { return v === null || v === undefined ? "–" : String(Number(v.toPrecision(4))); };
    entry.estimates.forEach(function (own, i) {
      const row = make("tr", {}, body), half = own[1] === null ? null : 1.96 * own[1], truth = run.true ? run.true[i] : null;
      make("th", { scope: "row", text: run.parameters[i][0] }, row);
      make("td", { text: run.parameters[i][1] }, row);
      make("td", { class: "number", text: f(own[0]) }, row);
      make("td", { class: "number", text: half === null || own[0] === null ? "–" : "[" + f(own[0] - half) + ", " + f(own[0] + half) + "]" }, row);
      make("td", { class: "number", text: f(truth) }, row);
    });
  }
  function recursion(parent, run, entry, method) {
    if (!entry.log || !run.parameters) return;
    const t = entry.log.time, shown = run.parameters.filter(function (own) { return entry.log.values[own[0]]; });
    make("h3", { text: "Log of the recursion" }, parent);
    make("p", { class: "sub", text: "Estimates against the time of the training records" + (run.true ? ", with the truth" : "") +
      "; what lies far outside at the beginning is left out." }, parent);
    const charts = make("div", { class: "charts small" }, parent);
    shown.forEach(function (own) {
      const log = entry.log.values[own[0]], path = decoded(log[2], log[0], log[1]), truth = run.true ? run.true[run.parameters.indexOf(own)] : null;
      const title = own[0] + (own[1] && own[1] !== "1" ? " (" + own[1] + ")" : " (-)"), known = truth !== null && truth !== undefined;
      const lines = [[t, path, "predicted", "estimate"]];
      if (known) lines.unshift([t, t.map(function () { return truth; }), "truth", "truth"]);
      figure(charts, "", "log-" + own[0], { width: 400, height: 190, x: range([t]), y: range([path, known ? [truth] : []]),
        xTitle: "time (s)", yTitle: title }, lines, "estimate of " + own[0] + " by " + method + " against time");
    });
  }
  function show(data, board, problems, state, changed) {
    const section = document.getElementById("runs"), title = document.getElementById("run-title");
    const body = document.getElementById("run");
    body.textContent = "";
    if (!Object.keys(data.runs).length) { section.hidden = true; return; }
    section.hidden = false;
    const places = Ranking.order(board), method = state.method || (places[0] ? places[0].method : data.methods[0]);
    const j = data.methods.indexOf(method);
    const stored = problems.filter(function (i) { return data.runs[i] && data.runs[i].methods[j]; });
    title.textContent = "Runs of " + method;
    if (!stored.length) { make("p", { text: "No curves of this method are on this page for these problems." }, body); return; }
    if (!stored.includes(Number(state.problem)) || state.problem === "") { // the one with the median error
      const size = function (i) { return board.errors[problems.indexOf(i)][j]; };
      const sorted = stored.slice().sort(function (a, b) { return size(a) - size(b) || a - b; });
      state.problem = String(sorted[(sorted.length - 1) >> 1]);
    }
    const label = make("label", { class: "wide" }, body), select = make("select", { id: "choose-problem" }, label);
    label.prepend(make("span", { text: "problem" }));
    stored.forEach(function (i) {
      const e = board.errors[problems.indexOf(i)][j];
      make("option", { value: String(i), text: titleOf(data, i, stored) + ": error " + (e === Infinity ? "infinite" : Ranking.number(e)) }, select);
    });
    select.value = state.problem;
    select.addEventListener("change", function () { state.problem = select.value; changed(); document.getElementById("choose-problem").focus(); });
    const i = Number(state.problem), run = data.runs[i], entry = run.methods[j], p = data.problems[i];
    make("p", { class: "sub", text: "Trained on " + p[2] + "; free run of the first seed along " + run.record + ", which took no part." }, body);
    curves(make("div", { class: "charts" }, body), run, entry, method);
    estimates(body, run, entry);
    recursion(body, run, entry, method);
  }
  function titleOf(data, i, others) { // conditions, and the records where they alone tell it from another problem
    const conditions = function (p) { return p[0] + " as " + p[1] + ", noise " + p[4] + (p[5] ? ", " + p[5] : ""); };
    const p = data.problems[i], text = conditions(p);
    const equal = others.map(function (k) { return data.problems[k]; }).filter(function (q) { return conditions(q) === text; });
    const differ = function (place) { return equal.some(function (q) { return q[place] !== p[place]; }); };
    return text + (differ(2) ? ", trained on " + p[2] : "") + (differ(3) ? ", predicting " + p[3] : "");
  }
  return { show: show };
})();
