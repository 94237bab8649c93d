// The question, how far its computation is, and the answers.
import { button, el, equation, fill, select, table } from "./dom.js";
import { colourOf, group, key, lying, timePlot, trackPlot, zoomButtons } from "./plots.js";
import { address, current, get, once, post, running } from "./server.js";

const ask = document.getElementById("ask"), job = document.getElementById("job"), place = document.getElementById("result");
const QUESTIONS = {
  check: ["Check", "What is wrong with sensors and files? Needs no simulation of the ship."],
  identify: ["Identify", "Which coefficients of a model fit, and can they be believed?"],
  diagnose: ["Diagnose", "What does a simulation get wrong, and what is the cause?"],
};
const NAMES = { check: "check", identify: "identification", diagnose: "diagnosis" };
let choices = null, coming = null;
let kind = "check", model = { identify: "auto", diagnose: "" }, method = "output-error";
let remembered = "", asked = "", listed = "", chosen = null, loaded = { id: "", view: null };

function failed(error) { document.getElementById("alert").textContent = error.message; }

// ---- the question

export function showQuestion(state) {
  const ready = Boolean(state.log?.records.length);
  ask.parentElement.hidden = !ready;
  if (!ready) return;
  if (remembered !== state.id) remember(state);
  coming ??= get("/api/choices").then((found) => { choices = found; asked = ""; showQuestion(current()); }).catch(failed);
  const missing = lacking(state);
  const own = missing.length ? "check" : kind;
  const now = JSON.stringify([own, missing, model, method, state.models, Boolean(running()), state.parts.some((part) => part.role === "train")]);
  if (now === asked) return;
  asked = now;
  const again = () => {
    showQuestion(current());
    post("/question", question()).catch(failed);
  };
  const rows = [el("fieldset", {}, el("legend", {}, "What do you want to know?"), Object.entries(QUESTIONS).map(([value, [title, what]]) =>
    el("label", { className: "radio", htmlFor: `kind-${value}` },
      el("input", { type: "radio", name: "kind", id: `kind-${value}`, value, checked: own === value, disabled: missing.length > 0 && value !== "check", onchange: () => { kind = value; again(); } }),
      el("b", {}, title), el("span", { className: "sub" }, what))))];
  if (missing.length) {
    rows.push(el("p", { className: "warn", id: "lacking" }, `Identify and diagnose need ${missing.join(", and ")}: the records have none. Say above which column it is, or drop a log that holds it together with this one. The sensors can be checked without it.`));
  }
  if (own !== "check" && !choices) rows.push(el("p", { className: "sub" }, "The lists of models and methods are being read …"));
  if (own !== "check" && choices) rows.push(el("div", { className: "tools" }, models(state, again), own === "identify" ? methods(again) : null));
  if (own === "diagnose" && model.diagnose === "") {
    rows.push(el("p", { className: "sub" }, "Without a simulation the records tell what steers the craft and what simpler models lack, and a model is built."));
  }
  rows.push(el("div", { className: "tools" }, button("Start", () => begin(own), { id: "start", className: "primary", disabled: running() || !state.parts.some((part) => part.role === "train") })));
  fill(ask, rows);
}

// What the records of the parts have not got that a model needs.
function lacking(state) {
  const used = state.parts.filter((part) => part.role !== "unused").map((part) => state.log.records[part.record]);
  return [...new Set(used.flatMap((one) => one?.lacks ?? []))];
}

function remember(state) {
  remembered = state.id;
  if (!state.question) return;
  kind = state.question.kind;
  method = state.question.method;
  if (kind !== "check") model = { ...model, [kind]: state.question.model };
}

function question(asked_ = kind) { return { kind: asked_, model: asked_ === "check" ? "" : model[asked_], method }; }

function models(state, again) {
  const options = (known) => Object.entries(known).map(([value, title]) => ({ value, text: `${value}: ${title}` }));
  const first = kind === "identify" ? [{ value: "auto", text: "the best of all that the records allow" }]
    : [{ value: "", text: "I have no simulation of the ship" }];
  const own = state.models.map((name) => ({ value: `file:${name}`, text: name }));
  return select("model", kind === "identify" ? "model" : "simulation of the ship", [...first,
    ...(own.length ? [{ label: "your models", options: own }] : []),
    { label: "ships", options: options(choices.vessels) }, { label: "families", options: options(choices.models) }],
  model[kind], (value) => { model = { ...model, [kind]: value }; again(); });
}

function methods(again) {
  return select("method", "method", Object.entries(choices.methods).map(([value, title]) => ({ value, text: `${value}: ${title}` })), method,
    (value) => { method = value; again(); });
}

function begin(own) {
  document.getElementById("alert").textContent = "";
  chosen = null;
  post("/analyses", question(own)).catch(failed);
}

// ---- how far it is

export function showJob(state) {
  const now = state.job;
  if (!now || now.state === "done" || now.state === "cancelled") { fill(job); return; }
  if (!running()) {
    fill(job, el("p", { className: "warn" }, now.state === "refused" ? "That cannot be computed: " : "That failed: ", now.message));
    return;
  }
  const stages = now.stages;
  const begins = !job.querySelector(".job");
  fill(job, el("div", { className: "job" },
    el("p", {}, el("b", {}, stages.length ? stages[stages.length - 1].text : "waiting for a free processor"), ` … ${Math.round(now.seconds)} s`,
      el("span", { className: "sub" }, ` (step ${Math.max(stages.length, 1)} of at most ${now.steps})`)),
    el("progress", { "aria-label": "progress", max: now.steps, value: stages.length - 1 }),
    el("ol", { className: "sub" }, stages.slice(0, -1).map((stage, i) => el("li", {}, `${stage.text}: ${(stages[i + 1].at - stage.at).toFixed(1)} s`))),
    button("Cancel", () => post("/cancel").catch(failed), { id: "cancel" })));
  if (begins) job.scrollIntoView({ block: "nearest" });
}

// ---- the answers

export async function showResult(state) {
  place.parentElement.hidden = !state.analyses.length;
  if (!state.analyses.length) { listed = ""; return; }
  const own = state.analyses.find((one) => one.id === chosen) ?? state.analyses[0];
  const now = JSON.stringify([own.id, state.analyses.map((one) => one.id)]);
  if (now === listed) return;
  const fresh = listed !== "" || state.job?.state === "done";
  listed = now;
  if (loaded.id !== own.id) loaded = { id: own.id, view: await get(address(`/analyses/${own.id}`)) };
  render(state, own, loaded.view);
  if (fresh && chosen === null) document.getElementById("result-title").focus();
}

function render(state, own, view) {
  const tabs = state.analyses.length > 1 ? el("div", { className: "tools", role: "group", "aria-label": "answers" }, state.analyses.map((one) =>
    button(`${one.id.split("-")[0]}. ${NAMES[one.kind]}${one.model ? ` of ${one.model}` : ""}`, () => { chosen = one.id; showResult(current()); },
      { id: `answer-${one.id}`, "aria-pressed": String(one.id === own.id) }))) : null;
  fill(place, tabs, el("div", { className: `verdict ${view.tone}`, id: "verdict" },
    view.label ? el("span", { className: "label" }, view.label) : null, el("p", { className: "first" }, view.sentence),
    view.told.length ? el("ul", {}, view.told.map((text) => el("li", {}, text))) : null),
  view.parts.filter((part) => !part.folded).map((part) => [el("h3", {}, part.title), part.blocks.map((block) => shown(block, view))]),
  downloads(own),
  view.parts.filter((part) => part.folded).map((part, i) =>
    el("details", { id: `part-${i}` }, el("summary", {}, part.title), part.blocks.map((block) => shown(block, view)))));
}

// A block of a part, by its kind.
const SHOWN = {
  text: (block) => el("p", { className: block.note ? "sub" : "" }, block.text),
  table: (block) => [block.title ? el("h4", {}, block.title) : null, table(block), block.note ? el("p", { className: "sub" }, block.note) : null],
  items: (block) => el("ul", { className: "items" }, block.rows.map(([title, ...texts]) =>
    el("li", {}, texts.length ? el("b", {}, title) : title, texts.map((text) => el("p", {}, text))))),
  equations: (block) => block.lines.map((line) => el("div", { className: `eq${line.new ? " fresh" : ""}`, tabIndex: 0 }, equation(line.html))),
  runs: (block, view) => runs(view),
};

function shown(block, view) { return SHOWN[block.kind](block, view); }

async function show(path) { window.open(await once(path), "_blank", "noopener"); }

async function save(path) { el("a", { href: `${await once(path)}&download=1`, download: "" }).click(); }

function downloads(own) {
  const folder = address(`/analyses/${own.id}`);
  const link = (name, text, open) => {
    const path = `${folder}/files/${name.split("/").map(encodeURIComponent).join("/")}`;
    return el("li", {}, button(text, () => open(path).catch(failed), { className: "link" }));
  };
  const report = own.files.find((name) => name.endsWith(".html"));
  const model = own.files.find((name) => name === "extended_model.json" || name === "model.json");
  const records = own.files.filter((name) => name.startsWith("records/") && name.endsWith(".csv"));
  return el("details", { id: "downloads", open: true }, el("summary", {}, "Take it with you"), el("ul", { className: "files" },
    el("li", {}, button("Everything (zip)", () => save(`${folder}/all.zip`).catch(failed), { className: "link" })),
    report ? link(report, "Report", show) : null,
    report ? link(report, "Report as a file (HTML)", save) : null,
    model ? link(model, `Model (${model})`, save) : null,
    link("log.map.yaml", "Map of the columns", save),
    records.map((name) => link(name, `Record ${name.slice(8)}`, save)),
    link("commands.sh", "The commands that do the same", save),
    link("notebook.ipynb", "The notebook that does the same", save)),
  button("Print, or save as PDF", () => window.print(), { id: "print" }));
}

function runs(view) {
  if (!view.traces.length) return null;
  const box = el("div");
  const draw = (i) => fill(box, ...trace(view, i, draw));
  const first = view.traces.findIndex((one) => one.role !== "train");
  draw(Math.max(first, 0));
  return box;
}

function trace(view, i, draw) {
  const own = view.traces[i];
  const shared = group();
  const styled = (curves) => curves.map((curve) => {
    const place_ = own.panels[0].curves.findIndex((one) => one.label === curve.label);
    return { ...curve, colour: colourOf(Math.max(place_, 0)), dash: place_ === 1 ? [6, 3] : undefined };
  });
  if (!own.panels.length) return [el("p", {}, "No channel was simulated along this record.")];
  const end = own.time[own.time.length - 1];
  const figure = (label, curves, height) => el("figure", {}, el("figcaption", {}, label, lying(curves) ? el("span", { className: "sub" }, ` ${lying(curves)}`) : null), timePlot({ label, time: own.time, curves, group: shared, height }));
  return [
    view.traces.length > 1 ? select("trace", "record", view.traces.map((one, k) => ({ value: String(k), text: `${one.record} (${one.role})` })), String(i),
      (value) => draw(Number(value))) : el("p", { className: "sub" }, `${own.record} (${own.role})`),
    key(styled(own.panels[0].curves)),
    el("p", { className: "sub screen" }, "Drag to zoom, all plots together; double-click shows the whole."),
    zoomButtons(shared, own.time[0], end, "trace"),
    el("div", { className: "charts" },
      figure("rudder, deg", [{ label: "rudder", values: own.rudder, colour: "soft" }], 120),
      own.panels.map((panel) => el("div", {}, figure(`${panel.label}, ${panel.unit}`, styled(panel.curves), 170),
        figure(`${panel.label}: measured − simulated, ${panel.unit}`, styled(panel.residuals), 120))),
      own.tracks.length ? el("figure", {}, el("figcaption", {}, "track"),
        trackPlot({ label: "track", time: own.time, group: shared, tracks: styled(own.tracks).map((one) => ({ ...one, dash: one.dash ? "6 3" : "" })) })) : null),
  ];
}
