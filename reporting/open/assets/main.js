// The page: logs come in, the state of the server is shown.
import * as columns from "./columns.js";
import { button, bytes, el, fill } from "./dom.js";
import * as parts from "./parts.js";
import * as result from "./result.js";
import { begin, current, enter, get, link, listen, post, remove, running, upload } from "./server.js";

const place = document.getElementById("logs"), alertBox = document.getElementById("alert");
const chooser = el("input", { type: "file", multiple: true, id: "chooser", className: "hidden", tabIndex: -1, "aria-hidden": "true",
  onchange: () => { take([...chooser.files]); chooser.value = ""; } });
const example = button("Start with an example", begun, { id: "example", title: "A simulated zigzag of the Mariner whose yaw rate has a bias" });
const zone = el("div", { className: "zone" },
  el("p", {}, "Drop logs here: CSV, Excel, NMEA 0183, MAT and others. The sidecar or the map of an import (YAML) goes with its log. A model.json is taken as a simulation of the ship."),
  el("div", { className: "tools" }, button("Choose files", () => chooser.click(), { id: "choose", className: "primary" }), chooser, example));
const files = el("ul", { className: "files", "aria-label": "files" });
const coming = el("div", { "aria-live": "polite" });
place.append(zone, coming, files);
let shown = "";

function showFiles(state) {
  const now = JSON.stringify([state.files, state.models]);
  if (now === shown) return;
  shown = now;
  example.hidden = state.files.length > 0;
  fill(files, state.files.map((file, i) => el("li", {}, `${file.name} (${bytes(file.bytes)}${file.beside ? ", says something of a log" : ""}) `,
    button("Remove", () => removed(file.name), { id: `file-${i}`, "aria-label": `remove ${file.name}` }))),
  state.models.map((name) => el("li", {}, `${name}: a model`)));
}

async function removed(name) {
  try {
    await remove(`/logs/${encodeURIComponent(name)}`);
    if (current().files.some((file) => !file.beside)) await columns.read({}, [], null);
  } catch (error) { failed(error); }
}

async function take(chosen) {
  await ready;
  alertBox.textContent = "";
  let logs = current().files.some((file) => !file.beside), came = false;
  for (const file of chosen) {
    const bar = el("progress", { max: 1, value: 0, "aria-label": file.name });
    fill(coming, el("p", {}, `${file.name} `, bar));
    try {
      const { kind } = await upload(file, (share) => { bar.value = share; });
      came ||= kind === "logs";
      logs ||= kind === "logs" && !/\.ya?ml$/i.test(file.name);
    } catch (error) { failed(error); }
  }
  fill(coming);
  if (came && logs) await columns.read({}, []);
}

async function begun() {
  await ready;
  alertBox.textContent = "";
  example.disabled = true;
  await post("/example").catch(failed);
  example.disabled = false;
}

function failed(error) { alertBox.textContent = error.message; }

for (const name of ["dragenter", "dragover"]) {
  document.addEventListener(name, (event) => { event.preventDefault(); zone.classList.add("over"); });
}
document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) zone.classList.remove("over"); });
document.addEventListener("drop", (event) => {
  event.preventDefault();
  zone.classList.remove("over");
  take([...event.dataTransfer.files]);
});

async function showWork() {
  const work = document.getElementById("work");
  const others = (await get("/api/projects")).filter((one) => one.id !== current()?.id);
  work.hidden = false;
  fill(work.querySelector("ul"), others.map((one) => el("li", {}, tab(one.id,
    `${one.files.join(", ")}${one.results ? `: ${one.results} answer${one.results > 1 ? "s" : ""}` : ""}`))),
  el("li", {}, tab("", "New work")));
}

function tab(work, text) {
  return button(text, () => link(work).then((address) => window.open(address, "_blank", "noopener")).catch(failed), { className: "link" });
}

window.addEventListener("hashchange", () => location.reload());

listen(async (state) => {
  showFiles(state);
  result.showJob(state);
  try {
    await columns.show(state);
    parts.show(current());
    result.showQuestion(current());
    await result.showResult(current());
  } catch (error) { failed(error); }
  document.title = running() ? "computing … – helmbench" : `${state.files[0]?.name ?? "helmbench"}${state.files.length ? " – helmbench" : ""}`;
});

async function open() {
  await enter();
  columns.start(await get("/api/about"));
  await begin().catch(failed);
  await showWork();
}

const ready = open().catch(failed);
