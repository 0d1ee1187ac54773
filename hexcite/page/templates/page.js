"use strict";
const alive = document.getElementById("alive");

function lost(is) {
  alive.hidden = !is;
  alive.textContent = is ? document.body.dataset.lost : "";
}

function go(address) {
  const target = new URL(address, location.href);
  if (target.pathname + target.search === location.pathname + location.search) location.reload();
  else location.assign(target);
}

function swap(place, html) { // what was opened stays open, what had the keyboard has it again
  const open = [...place.querySelectorAll("details")].map((each) => each.open);
  const focused = place.contains(document.activeElement) ? document.activeElement.tagName : null;
  place.innerHTML = html;
  [...place.querySelectorAll("details")].forEach((each, k) => { each.open = open[k] || false; });
  if (focused) place.querySelector(focused.toLowerCase())?.focus();
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

function upload(file, input) {
  const said = input.parentElement.querySelector(".progress");
  const request = new XMLHttpRequest();
  request.open("PUT", "/upload/" + encodeURIComponent(file.name));
  request.upload.addEventListener("progress", (event) => {
    said.textContent = input.dataset.busy + " " + Math.round(100 * event.loaded / event.total) + " %";
  });
  request.addEventListener("load", () => {
    if (request.status === 200) {
      const name = JSON.parse(request.responseText).name;
      go(input.dataset.to.endsWith("=") ? input.dataset.to + encodeURIComponent(name) : input.dataset.to);
    } else said.textContent = request.status === 413 ? input.dataset.large : file.name + ": " + request.status;
  });
  request.addEventListener("error", () => { said.textContent = ""; lost(true); });
  said.textContent = input.dataset.busy;
  request.send(file);
}

for (const input of document.querySelectorAll("input.upload")) {
  input.addEventListener("change", () => { if (input.files.length) upload(input.files[0], input); });
  const place = input.closest(".drop");
  if (!place) continue;
  for (const kind of ["dragover", "dragleave", "drop"]) {
    place.addEventListener(kind, (event) => {
      event.preventDefault();
      place.classList.toggle("over", kind === "dragover");
      if (kind === "drop" && event.dataTransfer.files.length) upload(event.dataTransfer.files[0], input);
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

const form = document.querySelector("form[data-preview]");
if (form) {
  let timer = 0, under = null;
  form.addEventListener("input", (event) => { // what is typed for a key that is not there switches it on
    if (event.target.name?.startsWith("w.")) form.elements["on." + event.target.name.slice(2)].checked = true;
    clearTimeout(timer);
    timer = setTimeout(async () => {
      under?.abort();
      under = new AbortController();
      try {
        const body = new URLSearchParams(new FormData(form));
        const answer = await fetch(form.dataset.preview, { method: "POST", body, signal: under.signal });
        if (answer.ok) document.getElementById("drawing").innerHTML = await answer.text();
        lost(false);
      } catch (error) {
        if (error.name !== "AbortError") lost(true);
      }
    }, 200);
  });
}
