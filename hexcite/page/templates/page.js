"use strict";
const alive = document.getElementById("alive");

function lost(is) {
  alive.hidden = !is;
  alive.textContent = is ? document.body.dataset.lost : "";
}

function go(address) {
  const target = new URL(address, location.href);
  if (target.pathname + target.search === location.pathname + location.search) {
    if (target.hash) location.hash = target.hash; // where what has come is shown
    location.reload();
  } else location.assign(target);
}

let toldLast = "", toldAt = 0;
function tell(place) { // for those who listen: a new state at once, progress every ten seconds at most
  const state = place.querySelector(".line strong")?.textContent.trim() || "";
  const line = place.querySelector(".line")?.dataset.progress || "";
  const text = place.getAttribute("aria-label") + ": " + [state, line].filter(Boolean).join(", ");
  const fresh = !toldLast.startsWith(place.getAttribute("aria-label") + ": " + state);
  if (text === toldLast || (!fresh && Date.now() - toldAt < 10000)) return;
  toldLast = text;
  toldAt = Date.now();
  document.getElementById("told").textContent = text;
}

function swap(place, html) { // what was opened stays open, what had the keyboard has it again
  const open = [...place.querySelectorAll("details")].map((each) => each.open);
  const focused = place.contains(document.activeElement) ? document.activeElement.tagName : null;
  place.innerHTML = html;
  [...place.querySelectorAll("details")].forEach((each, k) => { each.open = open[k] || false; });
  if (focused) place.querySelector(focused.toLowerCase())?.focus();
  tell(place);
}

for (const place of document.querySelectorAll("[data-job]:not([data-over])")) {
  const events = new EventSource("/jobs/" + place.dataset.job + "/events");
  events.addEventListener("open", () => lost(false));
  events.addEventListener("panel", (event) => swap(place, JSON.parse(event.data)));
  events.addEventListener("over", (event) => {
    events.close();
    go(JSON.parse(event.data) || location.pathname + location.search);
  });
  events.addEventListener("error", () => lost(true));
  addEventListener("pagehide", () => events.close());
}
if (document.querySelector("[data-job]:not([data-over])")) document.getElementById("jobs").scrollIntoView({ block: "nearest" });

for (const input of document.querySelectorAll(".here")) input.value = location.pathname + location.search;

function put(address, file, input, said) { // the answer to a file that is sent, which has the name that it got
  return new Promise((good, bad) => {
    const request = new XMLHttpRequest();
    request.open("PUT", address);
    request.upload.addEventListener("progress", (event) => {
      said.textContent = input.dataset.busy + " " + file.name + " " + Math.round(100 * event.loaded / event.total) + " %";
    });
    request.addEventListener("load", () => {
      if (request.status === 200) good(JSON.parse(request.responseText).name);
      else if (request.status === 413) bad(input.dataset.large);
      else if (request.status === 415 && input.dataset.unknown) bad(input.dataset.unknown.replace("{file}", file.name));
      else bad(file.name + ": " + request.status);
    });
    request.addEventListener("error", () => { bad(""); lost(true); });
    said.textContent = input.dataset.busy + " " + file.name;
    request.send(file);
  });
}

async function upload(files, input) { // several files are one run, in a folder that appears when all of them are there
  const said = input.parentElement.querySelector(".progress");
  said.classList.remove("error");
  const post = async (address) => (await (await fetch(address, { method: "POST" })).json()).name;
  try {
    const run = files.length > 1 && input.multiple ? await post("/runs") : "";
    let name = "";
    for (const file of run ? files : files.slice(0, 1)) {
      name = await put("/upload/" + encodeURIComponent(file.name) + (run && "?into=" + run), file, input, said);
    }
    if (run) name = await post("/runs/" + run);
    else if (name !== files[0].name && input.dataset.renamed) {
      const words = input.dataset.renamed.replace("{file}", files[0].name).replace("{name}", name);
      sessionStorage.setItem("renamed", JSON.stringify({ name, words }));
    }
    if (input.dataset.ask) ask(input.dataset.ask, name);
    else go(/=$|^\/urdf\/$/.test(input.dataset.to) ? input.dataset.to + encodeURIComponent(name) : input.dataset.to);
  } catch (reason) {
    said.textContent = typeof reason === "string" ? reason : "";
    said.classList.add("error");
    if (typeof reason !== "string") lost(true);
  }
}

function ask(address, recording) {
  const form = document.createElement("form");
  const field = document.createElement("input");
  Object.assign(form, { method: "post", action: address, hidden: true });
  Object.assign(field, { type: "hidden", name: "recording", value: recording });
  form.append(field);
  document.body.append(form);
  form.submit();
}

async function dropped(transfer) { // files, and those in folders that were dropped
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  const plain = [...transfer.files];
  const folders = entries.filter((entry) => entry.isDirectory);
  const inside = await Promise.all(folders.map(async (folder) => {
    const listed = await new Promise((good, bad) => folder.createReader().readEntries(good, bad));
    return Promise.all(listed.filter((entry) => entry.isFile).map((entry) => new Promise((good, bad) => entry.file(good, bad))));
  }));
  return folders.length ? [...plain.filter((file) => !folders.some((folder) => folder.name === file.name)), ...inside.flat()] : plain;
}

for (const input of document.querySelectorAll("input.upload[data-renamed]")) { // said where the file is
  const renamed = JSON.parse(sessionStorage.getItem("renamed") ?? "null");
  if (renamed?.name !== new URLSearchParams(location.search).get("recording")) continue;
  input.parentElement.querySelector(".progress").textContent = renamed.words;
}

for (const list of document.querySelectorAll("[data-ticks]")) { // what was done at the machine stays ticked
  const key = "ticks " + location.pathname + " " + list.dataset.ticks, boxes = [...list.querySelectorAll("input")];
  const ticked = (localStorage.getItem(key) ?? "").split(",");
  boxes.forEach((box, k) => { box.checked = ticked.includes(String(k)); });
  list.addEventListener("change", () => {
    localStorage.setItem(key, boxes.flatMap((box, k) => (box.checked ? [k] : [])).join(","));
  });
}

for (const input of document.querySelectorAll("input.upload")) {
  input.addEventListener("change", () => { if (input.files.length) upload([...input.files], input); });
  const place = input.closest(".drop");
  if (!place) continue;
  for (const kind of ["dragover", "dragleave", "drop"]) {
    place.addEventListener(kind, async (event) => {
      event.preventDefault();
      place.classList.toggle("over", kind === "dragover");
      if (kind !== "drop") return;
      const files = await dropped(event.dataTransfer);
      if (files.length) upload(files, input);
    });
  }
}

for (const part of document.querySelectorAll("details[data-frame]")) {
  const show = () => {
    if (!part.open || part.querySelector("iframe")) return;
    const frame = document.createElement("iframe");
    frame.setAttribute("sandbox", "allow-scripts");
    frame.title = part.querySelector("summary").textContent;
    frame.src = part.dataset.frame;
    part.append(frame);
  };
  part.addEventListener("toggle", show);
  show();
}

const decimal = document.documentElement.lang === "de" ? "," : ".";

// 3-D: a frame with an origin of its own draws what it is sent, and says which label was clicked.
const spaces = [];
function space(place) {
  const frame = document.createElement("iframe"), [play, pause, pose, of] = place.dataset.words.split(" ");
  let scene = null, ready = false;
  const send = (next = scene) => {
    scene = next;
    if (ready && scene) frame.contentWindow.postMessage({ scene: { ...scene, pick: Boolean(place.dataset.pick), picked: document.getElementById(place.dataset.pick ?? "")?.value }, words: { play, pause, pose, of, decimal } }, "*");
  };
  addEventListener("message", (event) => {
    if (event.source !== frame.contentWindow) return;
    if (event.data.ready) { ready = true; frame.removeAttribute("tabindex"); send(); }
    if (event.data.drawn) place.classList.add("drawn");
    if (event.data.failed) place.textContent = place.dataset.failed;
    const menu = document.getElementById(place.dataset.pick ?? "");
    if (menu && [...menu.options].some((each) => each.value === event.data.picked)) {
      menu.value = event.data.picked;
      menu.dispatchEvent(new Event("change"));
    }
  });
  document.getElementById(place.dataset.pick ?? "")?.addEventListener("change", (event) => { // chosen by the keyboard
    if (event.isTrusted) send();
  });
  frame.setAttribute("sandbox", "allow-scripts");
  frame.title = place.dataset.title;
  frame.tabIndex = -1; // until it answers: keys would be lost in it
  frame.src = "/space";
  place.append(frame);
  if (place.dataset.src) {
    fetch(place.dataset.src).then(async (answer) => {
      if (answer.ok) send(await answer.json());
      else place.textContent = place.dataset.failed;
    }, () => lost(true));
  } else spaces.push(send);
  return send;
}
const drawnScene = () => JSON.parse(document.getElementById("scene")?.textContent || "null");
function showSpaces() { // after the first paint, which does not wait for 3-D
  for (const place of document.querySelectorAll("[data-space]")) space(place);
  for (const send of spaces) send(drawnScene());
}
requestAnimationFrame(() => setTimeout(showSpaces, 0));

const form = document.querySelector("form[data-preview]");
if (form) {
  const draw = (html) => { // what cannot be drawn leaves the pictures before it, paler
    const place = document.getElementById("drawing"), before = document.getElementById("live");
    place.innerHTML = html;
    if (before && !document.getElementById("live")) {
      before.classList.add("before");
      place.prepend(before);
    }
    document.getElementById("remarks")?.remove(); // those on what is typed stand beside the pictures
    refused = JSON.parse(document.getElementById("refused").textContent || "{}");
    mark();
  };
  let refused = {};
  const mark = () => { // why a value cannot be, at its field; of the one that is typed once it is left
    for (const field of form.querySelectorAll("input[id], select[id]")) {
      const words = refused[field.id], marked = field.hasAttribute("aria-invalid");
      if (words && !marked && field === document.activeElement && !form.hasAttribute("data-given")) continue;
      if (!words && !marked) continue;
      document.getElementById("e." + field.id)?.remove();
      for (const name of ["aria-invalid", "aria-describedby"]) field.removeAttribute(name);
      if (!words) continue;
      field.setAttribute("aria-invalid", "true");
      field.setAttribute("aria-describedby", "e." + field.id);
      const said = document.createElement("small");
      Object.assign(said, { id: "e." + field.id, className: "wrong", innerHTML: words });
      (field.closest(".value") ?? field).after(said);
    }
  };
  form.addEventListener("focusout", () => setTimeout(mark, 0));
  const opened = (each) => { // with all that it is folded in
    for (let at = each?.closest("details"); at; at = at.parentElement.closest("details")) at.open = true;
  };
  for (const each of form.querySelectorAll("[aria-invalid]")) opened(each);
  addEventListener("hashchange", () => opened(document.getElementById(decodeURIComponent(location.hash.slice(1)))));
  opened(document.getElementById(decodeURIComponent(location.hash.slice(1))));
  form.querySelector("[aria-invalid]")?.focus();
  let under = false, again = false;
  const preview = async () => { // the newest values, as soon as the answer before is there
    again = under;
    if (under) return;
    under = true;
    try {
      const body = new URLSearchParams(new FormData(form));
      const answer = await fetch(form.dataset.preview, { method: "POST", body });
      if (answer.ok) draw(await answer.text());
      for (const send of spaces) send(drawnScene());
      lost(false);
    } catch { lost(true); }
    under = false;
    document.documentElement.dataset.previews = String(Number(document.documentElement.dataset.previews ?? 0) + 1);
    if (again) preview();
  };
  const fieldOf = (name) => form.elements["v." + name] ?? form.elements["w." + name];
  const numbersIn = (text) => (text.match(/[-+]?[0-9.]+(e[-+]?[0-9]+)?/gi) ?? []).map(Number);
  const movers = [...document.querySelectorAll("[data-field]")].filter((each) => fieldOf(each.dataset.field));
  const said = (mover) => {
    const output = mover.parentElement.querySelector(`#${mover.id} + output`);
    if (output) output.textContent = output.textContent.replace(/^\S+/, Number(mover.value).toFixed(1).replace(".", decimal));
  };
  for (const mover of movers) {
    mover.addEventListener("input", () => {
      const field = fieldOf(mover.dataset.field), item = Number(mover.dataset.item ?? -1);
      const value = Math.round(10 * Number(mover.value)) / 10, list = numbersIn(field.value);
      if (item >= 0) field.value = "[" + [0, 1, 2].map((k) => (k === item ? value : list[k] ?? 0).toFixed(3)).join(", ") + "]";
      else field.value = value.toFixed(1);
      field.dispatchEvent(new Event("input", { bubbles: true }));
    });
  }
  for (const button of document.querySelectorAll("[data-turn]")) {
    button.addEventListener("click", () => {
      const mover = document.getElementById(button.dataset.for);
      const angle = Number(mover.value) + Number(button.dataset.turn);
      mover.value = String(Math.round(1000 * (((angle + 180) % 360 + 360) % 360 - 180)) / 1000);
      mover.dispatchEvent(new Event("input"));
    });
  }
  document.addEventListener("click", (event) => { // a proposal becomes what is typed
    const take = JSON.parse(event.target.closest("[data-take]")?.dataset.take ?? "{}");
    for (const [name, value] of Object.entries(take)) {
      const field = fieldOf(name), unit = form.elements["u." + name];
      if (unit) unit.selectedIndex = 0;
      field.value = value;
      opened(field);
      field.dispatchEvent(new Event("input", { bubbles: true }));
      field.focus();
    }
  });
  form.addEventListener("input", (event) => { // what is typed for a key that is not there switches it on
    const name = event.target.name ?? "";
    const column = event.target.dataset?.column;
    for (const each of column ? form.querySelectorAll(`[data-of="${column}"]`) : []) each.value = event.target.value;
    const on = form.elements["on." + name.slice(2)] ?? form.elements["on.joints"];
    if (on && (name.startsWith("w.") || (column && form.querySelector(`.proposed[data-of="${column}"]`)))) on.checked = true;
    for (const mover of movers.filter((each) => fieldOf(each.dataset.field) === event.target)) {
      const value = numbersIn(event.target.value)[Math.max(0, Number(mover.dataset.item ?? 0))];
      if (Number.isFinite(value) && document.activeElement !== mover) mover.value = String(value);
      said(mover);
    }
    const whose = event.target.closest("td, .fields > div")?.querySelector(".mark.example, .mark.typical");
    if (whose && name.startsWith("v.")) {
      whose.className = "mark mine";
      whose.textContent = form.dataset.mine;
    }
    preview();
  });
  if (form.hasAttribute("data-given")) preview();
}

for (const kept of document.querySelectorAll("form[data-unsaved]")) { // typed values are not lost without a question
  const now = () => new URLSearchParams(new FormData(kept)).toString(), before = now();
  let saving = false;
  addEventListener("beforeunload", (event) => {
    if (!saving && (kept.hasAttribute("data-given") || now() !== before)) event.preventDefault();
  });
  addEventListener("pageshow", () => { saving = false; });
  const key = "place " + kept.getAttribute("action"); // the address of a refused form is another one
  const names = (each) => each.id || each.parentElement.closest("details")?.id + " more";
  const groups = () => [...kept.querySelectorAll("details")];
  kept.addEventListener("submit", () => { // after it the same groups are open, and the same field is in sight
    saving = true;
    const inSight = [...kept.querySelectorAll("[id^='v.'], [id^='w.']")].find((each) => each.getBoundingClientRect().top >= 0);
    const field = inSight?.id.slice(2) ?? "", top = (inSight ?? kept).getBoundingClientRect().top;
    const open = Object.fromEntries(groups().map((each) => [names(each), each.open]));
    sessionStorage.setItem(key, JSON.stringify({ field, top, open }));
  });
  const was = JSON.parse(sessionStorage.getItem(key) ?? "null");
  sessionStorage.removeItem(key);
  if (!was) continue;
  for (const each of groups()) each.open = (was.open[names(each)] ?? each.open) || Boolean(each.querySelector("[aria-invalid]"));
  if (kept.hasAttribute("data-given")) continue; // the first value that cannot be has the keyboard
  const there = document.getElementById("v." + was.field) ?? document.getElementById("w." + was.field) ?? kept;
  scrollBy({ top: there.getBoundingClientRect().top - was.top, behavior: "instant" });
}
