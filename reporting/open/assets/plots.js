/* global uPlot */
// Curves over time whose cursors and ranges move together, and tracks.
import { button, el } from "./dom.js";

const plots = new Set();

export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

const CURVES = ["measured", "before", "after", "fourth", "fifth", "sixth", "seventh", "eighth"];
export function colourOf(place) { return CURVES[place % CURVES.length]; }

// A line under others is wider than they are, so that it is seen on both sides of them.
function widthOf(place, count) { return 1.4 + 1.6 * Math.min(count - 1 - place, 3); }

const ON = 0.01;  // of the range: what no eye tells apart

// Which of the curves or tracks lie on an earlier one: as sentences, "" where none does.
export function lying(curves) {
  const axes = (curve) => (curve.values ? [curve.values] : [curve.north, curve.east]);
  const known = (k) => curves.flatMap((curve) => axes(curve)[k].filter((value) => value !== null));
  const reach = (values) => values.reduce((most, value) => Math.max(most, value), -Infinity) - values.reduce((least, value) => Math.min(least, value), Infinity);
  const span = Math.max(...axes(curves[0] ?? { values: [] }).map((_, k) => reach(known(k))));
  const same = (a, b) => axes(a).every((own, k) => own.length === axes(b)[k].length
    && own.every((value, i) => value === null || axes(b)[k][i] === null || Math.abs(value - axes(b)[k][i]) <= ON * span));
  return curves.flatMap((curve, i) => {
    const under = curves.slice(0, i).find((other) => same(curve, other));
    return under ? [`“${curve.label}” lies on “${under.label}”: they agree.`] : [];
  }).join(" ");
}

// Plots that show the same time: { range, point } are shared.
export function group() {
  const members = new Set();
  const shared = {
    range: null,
    members,
    zoom(min, max) {
      shared.range = min === null ? null : [min, max];
      for (const member of members) member.zoom(shared.range);
    },
    point(time, source) {
      for (const member of members) if (member !== source) member.point(time);
    },
  };
  return shared;
}

// A plot of curves over time.  options: time, curves [{label, values, colour, dash}], unit, label, height, group,
// bands () => [{from, to, role}], chosen (from, to) => ..., where a drag chooses rather than zooms.
export function timePlot(options) {
  const frame = el("div", { className: "plot", role: "img", "aria-label": `${options.label} over time` });
  const shared = options.group;
  let plot = null;

  function make() {
    plot?.destroy();
    const axis = { stroke: colour("soft"), grid: { stroke: colour("line"), width: 1 }, ticks: { stroke: colour("line") },
      font: "12px system-ui, sans-serif" };
    plot = new uPlot({
      width: Math.max(240, frame.clientWidth || 600),
      height: options.height ?? 150,
      legend: { show: false },
      scales: { x: { time: false } },
      axes: [
        { ...axis, size: 32, values: (_, splits) => splits.map((v) => `${v}`) },
        { ...axis, size: 62, space: 18 },
      ],
      cursor: { drag: { x: true, y: false, setScale: false, dist: 5 }, points: { size: 6 } },
      series: [{}, ...options.curves.map((curve, i) => ({
        label: curve.label, stroke: colour(curve.colour), width: widthOf(i, options.curves.length), dash: curve.dash,
        points: { show: false }, spanGaps: false,
      }))],
      hooks: {
        setSelect: [(u) => {
          if (u.select.width < 2) return;
          const from = u.posToVal(u.select.left, "x"), to = u.posToVal(u.select.left + u.select.width, "x");
          if (options.chosen) options.chosen(from, to);
          else {
            u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            shared.zoom(from, to);
          }
        }],
        setCursor: [(u) => {
          if (u.cursor.left === undefined) return;
          shared.point(u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null, member);
        }],
        drawClear: [(u) => bands(u)],
      },
    }, [options.time, ...options.curves.map((curve) => curve.values)], frame);
    plot.root.addEventListener("dblclick", () => shared.zoom(null, null));
    if (shared.range) member.zoom(shared.range);
  }

  function bands(u) {
    for (const band of options.bands?.() ?? []) {
      const left = u.valToPos(band.from, "x", true), right = u.valToPos(band.to, "x", true);
      u.ctx.save();
      u.ctx.globalAlpha = band.role === "chosen" ? 0.3 : 0.16;
      u.ctx.fillStyle = colour({ train: "accent", held_out: "before", chosen: "soft" }[band.role] ?? "line");
      u.ctx.beginPath();
      u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
      u.ctx.clip();
      u.ctx.fillRect(left, u.bbox.top, right - left, u.bbox.height);
      u.ctx.restore();
    }
  }

  const member = {
    zoom(range) {
      if (!plot) return;
      const [min, max] = range ?? [options.time[0], options.time[options.time.length - 1]];
      plot.setScale("x", { min, max });
    },
    point(time) {
      if (!plot) return;
      if (time === null) plot.setCursor({ left: -10, top: -10 }, false);
      else plot.setCursor({ left: plot.valToPos(time, "x"), top: 10 }, false);
    },
    redraw() { plot?.redraw(); },
    clear() { plot?.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false); },
  };
  shared.members.add(member);
  keep(frame, make, () => plot?.setSize({ width: Math.max(240, frame.clientWidth), height: options.height ?? 150 }));
  frame.member = member;
  return frame;
}

// Two columns {label, time, values} over time, each with an axis of its own.
export function pairPlot(left, right) {
  const frame = el("div", { className: "plot", role: "img", "aria-label": `${left.label} and ${right.label} over time` });
  let plot = null;
  const start = Math.min(...[left, right].flatMap((one) => one.time.filter((value) => value !== null)));
  const sorted = ({ time, values }) => {
    const places = [...time.keys()].filter((i) => time[i] !== null).sort((a, b) => time[a] - time[b]);
    return [places.map((i) => time[i] - start), places.map((i) => values[i])];
  };
  function make() {
    plot?.destroy();
    const grid = { stroke: colour("line"), width: 1 };
    const axis = (scale, side, name) => ({ scale, side, stroke: colour(name), grid: side === 1 ? { show: false } : grid, ticks: grid, size: 62, space: 18, font: "12px system-ui, sans-serif" });
    const series = (one, scale, name, i) => ({ label: one.label, scale, stroke: colour(name), width: widthOf(i, 2), points: { show: false } });
    plot = new uPlot({
      width: Math.max(240, frame.clientWidth || 600), height: 200, legend: { show: false },
      scales: { x: { time: false } }, cursor: { drag: { x: true, y: false } },
      axes: [{ ...axis("x", 2, "soft"), size: 32, space: 50, values: (_, splits) => splits.map((v) => `${v}`) }, axis("left", 3, "measured"), axis("right", 1, "before")],
      series: [{}, series(left, "left", "measured", 0), series(right, "right", "before", 1)],
    }, uPlot.join([sorted(left), sorted(right)]), frame);
  }
  keep(frame, make, () => plot?.setSize({ width: Math.max(240, frame.clientWidth), height: 200 }));
  return frame;
}

// Made when it is in the page, anew when the colours change, as wide as its place.
function keep(frame, make, resize) {
  const one = { frame, make };
  plots.add(one);
  let width = 0;
  new ResizeObserver(() => {
    if (!frame.isConnected || frame.clientWidth === width || !frame.clientWidth) return;
    const first = width === 0;
    width = frame.clientWidth;
    if (first) make(); else resize();
  }).observe(frame);
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  for (const one of plots) {
    if (one.frame.isConnected) one.make();
    else plots.delete(one);
  }
});

// ---- tracks: north upwards, both axes of one scale

const SVG = "http://www.w3.org/2000/svg";
function svg(tag, properties, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(properties)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// tracks: [{label, north, east, colour, dash}] over options.time; the group's range and cursor hold for it, too.
export function trackPlot(options) {
  const drawing = svg("svg", { role: "img", "aria-label": options.label, class: "track", viewBox: "0 0 400 320" });
  const shared = options.group;
  const tracks = options.tracks;
  let view = null;

  function draw(range) {
    const inside = (i, time) => !range || (time[i] >= range[0] && time[i] <= range[1]);
    const known = [];
    for (const track of tracks) {
      for (let i = 0; i < track.north.length; i += 1) {
        if (inside(i, track.time ?? options.time) && track.north[i] !== null && track.east[i] !== null) {
          known.push([track.east[i], track.north[i]]);
        }
      }
    }
    drawing.replaceChildren();
    if (!known.length) return;
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const [x, y] of known) {
      left = Math.min(left, x); right = Math.max(right, x); low = Math.min(low, y); high = Math.max(high, y);
    }
    const scale = Math.min(330 / Math.max(right - left, 1e-9), 270 / Math.max(high - low, 1e-9));
    view = { x: (e) => 210 + scale * (e - (left + right) / 2), y: (n) => 145 - scale * (n - (low + high) / 2) };
    const bar = nice(110 / scale);
    drawing.append(
      svg("line", { x1: 20, x2: 20 + bar * scale, y1: 306, y2: 306, class: "scale" }),
      Object.assign(svg("text", { x: 26 + bar * scale, y: 310 }), { textContent: `${bar} m` }),
      Object.assign(svg("text", { x: 10, y: 20 }), { textContent: "N ↑" }));
    tracks.forEach((track, i_) => {
      let path = "", pen = false;
      for (let i = 0; i < track.north.length; i += 1) {
        const drawn = inside(i, track.time ?? options.time) && track.north[i] !== null && track.east[i] !== null;
        if (drawn) path += `${pen ? "L" : "M"}${view.x(track.east[i]).toFixed(1)} ${view.y(track.north[i]).toFixed(1)}`;
        pen = drawn;
      }
      drawing.append(svg("path", { d: path, class: `curve ${track.colour}`, "stroke-width": widthOf(i_, tracks.length), "stroke-dasharray": track.dash ?? "" }));
    });
  }

  const member = {
    zoom(range) { draw(range); },
    point(time) {
      for (const dot of drawing.querySelectorAll("circle")) dot.remove();
      if (time === null || !view) return;
      for (const track of tracks) {
        const i = nearest(track.time ?? options.time, time);
        if (track.north[i] === null || track.east[i] === null) continue;
        drawing.append(svg("circle", { cx: view.x(track.east[i]), cy: view.y(track.north[i]), r: 4, class: track.colour }));
      }
    },
  };
  shared.members.add(member);
  draw(shared.range);
  return drawing;
}

function nearest(time, at) {
  let [low, high] = [0, time.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (time[middle] < at) low = middle; else high = middle;
  }
  return Math.abs(time[low] - at) <= Math.abs(time[high] - at) ? low : high;
}

function nice(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return [1, 2, 5, 10].map((step) => step * power).filter((step) => step <= length * 1.001).pop() ?? power;
}

export function key(entries) {
  return el("p", { className: "key" }, entries.map(({ label, colour: name, dash }) =>
    el("span", { className: `${name}${dash ? " dashed" : ""}` }, el("i"), label)));
}

export function zoomButtons(shared, from, to, prefix) {
  const step = (share) => {
    const [min, max] = shared.range ?? [from, to];
    return [min, max, (max - min) * share];
  };
  return el("div", { className: "tools", role: "group", "aria-label": "time range" },
    button("Zoom in", () => { const [a, b, d] = step(0.25); shared.zoom(a + d, b - d); }, { id: `${prefix}-in` }),
    button("Zoom out", () => { const [a, b, d] = step(0.5); shared.zoom(Math.max(from, a - d), Math.min(to, b + d)); }, { id: `${prefix}-out` }),
    button("Earlier", () => { const [a, b, d] = step(0.25); const m = Math.min(d, a - from); shared.zoom(a - m, b - m); }, { id: `${prefix}-earlier` }),
    button("Later", () => { const [a, b, d] = step(0.25); const m = Math.min(d, to - b); shared.zoom(a + m, b + m); }, { id: `${prefix}-later` }),
    button("Whole", () => shared.zoom(null, null), { id: `${prefix}-whole` }));
}

// ---- a small curve without axes

export function spark(values) {
  const known = values.filter((value) => value !== null);
  const drawing = svg("svg", { class: "spark", viewBox: "0 0 120 32", preserveAspectRatio: "none", "aria-hidden": "true" });
  if (known.length < 2) return drawing;
  const low = Math.min(...known), high = Math.max(...known), span = high - low || 1;
  let path = "", pen = false;
  values.forEach((value, i) => {
    if (value !== null) path += `${pen ? "L" : "M"}${((118 * i) / (values.length - 1) + 1).toFixed(1)} ${(30 - (28 * (value - low)) / span).toFixed(1)}`;
    pen = value !== null;
  });
  drawing.append(svg("path", { d: path }));
  return drawing;
}
