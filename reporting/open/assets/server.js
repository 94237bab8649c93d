// The server's state of this tab's project, asked for again and again; changes go to the server at once.

const KEY = "helmbench-key";
let key = sessionStorage.getItem(KEY);  // of this tab alone; a reload keeps it
let project = "";
let state = null;
let timer = 0;
const listeners = [];

export function current() { return state; }
export function listen(listener) { listeners.push(listener); }
export function address(path = "") { return `/api/projects/${encodeURIComponent(project)}${path}`; }

const bearer = (secret) => ({ authorization: `Bearer ${secret}` });

export async function get(path) { return told(await fetch(path, { headers: bearer(key) })); }

async function told(answer) {
  const content = await answer.json().catch(() => ({ error: `the server answered ${answer.status}` }));
  if (!answer.ok) throw new Error(content.error);
  return content;
}

async function send(method, path, content) {
  const answer = await fetch(path, {
    method, headers: { "content-type": "application/json", ...bearer(key) },
    body: content === undefined ? undefined : JSON.stringify(content),
  });
  return told(answer);
}

// ---- the key: the link holds a code, which leaves the address and is exchanged at once

export async function enter() {
  const given = new URLSearchParams(location.hash.slice(1));
  if (given.get("code") === null) return;
  history.replaceState(null, "", `#${given.get("work") ?? ""}`);
  key = (await told(await fetch("/api/key", { method: "POST", headers: bearer(given.get("code")) }))).key;
  sessionStorage.setItem(KEY, key);
}

// The address of the page for another tab.
export async function link(work) {
  const { code } = await send("POST", "/api/codes");
  return `/#${new URLSearchParams({ code, work })}`;
}

// An address that the browser may load once without the key.
export async function once(path) {
  const { ticket } = await send("POST", `/api/tickets?path=${encodeURIComponent(path)}`);
  return `${path}?ticket=${ticket}`;
}

// ---- the project of this tab: its id is in the address, so that a reload or another tab finds it again

export async function begin() {
  const asked = decodeURIComponent(location.hash.slice(1));
  if (asked) {
    project = asked;
    try { return take(await get(address())); } catch (error) {
      await fresh();
      throw error;
    }
  }
  return fresh();
}

async function fresh() {
  const made = await send("POST", "/api/projects");
  project = made.id;
  history.replaceState(null, "", `#${encodeURIComponent(project)}`);
  take(made);
}

function take(found) {
  const changed = state === null || JSON.stringify(state) !== JSON.stringify(found);
  state = found;
  if (changed) for (const listener of listeners) listener(state);
  schedule();
}

export function running() {
  return state?.job && (state.job.state === "waiting" || state.job.state === "running");
}

function schedule() {
  clearTimeout(timer);
  timer = setTimeout(look, running() ? 300 : 3000);
}

async function look() {
  if (document.hidden && !running()) return schedule();
  try {
    take(await get(address()));
    document.body.classList.remove("lost");
  } catch {
    document.body.classList.add("lost");
    schedule();
  }
}

document.addEventListener("visibilitychange", () => { if (!document.hidden && state) look(); });

export async function post(path, content) { take(await send("POST", address(path), content)); }
export async function remove(path) { take(await send("DELETE", address(path))); }

// ---- files

export function upload(file, progress) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", `${address("/logs")}?name=${encodeURIComponent(file.name)}`);
    request.setRequestHeader("content-type", "application/octet-stream");
    request.setRequestHeader("authorization", bearer(key).authorization);
    request.upload.onprogress = (event) => { if (event.lengthComputable) progress(event.loaded / event.total); };
    request.onerror = () => reject(new Error(`${file.name}: the server did not take the file`));
    request.onload = () => {
      if (request.status === 200) return resolve(JSON.parse(request.responseText));
      let message = `the server answered ${request.status}`;
      try { message = JSON.parse(request.responseText).error; } catch { /* no JSON */ }
      reject(new Error(`${file.name}: ${message}`));
    };
    request.send(file);
  });
}
