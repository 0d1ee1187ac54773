"use strict";
// Draws the figures that stand on the page as data, in the page's own colours, and moves the machine.

const PALETTE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const dark = window.matchMedia("(prefers-color-scheme: dark)");
const narrow = window.matchMedia("(max-width: 40rem)");
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function template() {
  const ink = colour("--ink"), line = colour("--line"), clear = "rgba(0,0,0,0)";
  const axis = {
    gridcolor: line, zerolinecolor: line, linecolor: line, automargin: true, title: { standoff: 8 },
    exponentformat: "power", minexponent: 4,
  };
  const space = { gridcolor: line, zerolinecolor: line, showbackground: false, color: ink };
  return {
    layout: {
      paper_bgcolor: clear, plot_bgcolor: clear, colorway: PALETTE,
      font: { color: ink, family: "system-ui, sans-serif", size: 13 },
      xaxis: axis, yaxis: axis, scene: { xaxis: space, yaxis: space, zaxis: space },
      margin: { l: 10, r: 10, t: 30, b: 18 },
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, bgcolor: clear },
      modebar: { bgcolor: clear, color: colour("--soft"), activecolor: ink },
      hoverlabel: { bgcolor: colour("--raised"), font: { color: ink } },
    },
  };
}

function draw(div, data, layout) {
  const config = {
    displaylogo: false, responsive: true,
    displayModeBar: narrow.matches ? false : "hover", // on a phone it is there always, and covers the legend
    toImageButtonOptions: { format: "svg", filename: "hexcite-" + div.id },
  };
  div.classList.add("live"); // in place of its picture; plotly measures what it draws into
  return Plotly.newPlot(div, data, { ...layout, template: template() }, config);
}

// Typed arrays stand in the data as base64; the scene is ours to decode, the figures are plotly's.
function numbers(packed) {
  const raw = Uint8Array.from(atob(packed.bdata), (c) => c.charCodeAt(0));
  return new Float32Array(raw.buffer);
}

const columns = (lines) => [0, 1, 2].map((k) => lines.flatMap((line) => [...line.map((p) => p[k]), null]));
const BASE = 0; // the frame that stands still

// A machine that moves, and the words of its buttons. Lines of its parts are points in frames that move: rows of (R p)
// of each frame, in mm. A page that shows this one in a frame of its own may send another scene at any time.
let player = null;
if (document.body.classList.contains("space")) { // the wheel scrolls the page around; with Ctrl, or a pinch, it zooms
  addEventListener("wheel", (event) => { if (!event.ctrlKey) event.stopPropagation(); }, { capture: true });
}
const machine = (div, scene, words) => (player ??= playerOf(div)).take(scene, words);
const alone = () => document.body.classList.contains("space"); // nothing but the machine
const escaped = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;"); // plotly reads some HTML in labels
const LIT = 0.99, MOST_LIMITS = 8;
const HELD = 6, NEAR = 28; // [px] that a click may move, and from a label

function playerOf(div) {
  const slider = document.getElementById("scrub"), button = document.getElementById("play");
  const instant = document.getElementById("instant"), limits = document.getElementById("used");
  let scene, t, frames, used = null, moving = [], drawn = false;
  let shown = 0, wanted = 0, busy = true, began = null;
  let words = { play: "Play", pause: "Pause", pose: "pose", of: "of", path: "path", poses: "poses" };

  const placed = (point, frame, k) => {
    if (frame === BASE) return point;
    const from = 12 * scene.moving * k + 12 * (frame - 1), [u, v, w] = point;
    return [0, 4, 8].map((row) => frames[from + row] * u + frames[from + row + 1] * v + frames[from + row + 2] * w + frames[from + row + 3]);
  };
  const lines = (part, k) => part.lines.map((line) => line.points.map((p, i) => placed(p, line.frames[i], k)));
  const stands = (part) => part.lines.every((line) => line.frames.every((frame) => frame === BASE));
  const trace = (part, k) => {
    const [x, y, z] = columns(lines(part, k)), dots = part.lines.every((line) => line.points.length === 1);
    const style = dots ? { mode: "markers", marker: { size: part.width, color: part.colour } }
      : { mode: "lines", line: { width: part.width, color: part.colour } };
    return { type: "scatter3d", x, y, z, name: part.name, hoverinfo: "name", showlegend: part.legend, ...style };
  };
  const named = () => {
    const [x, y, z] = columns([scene.labels.map(([, point, frame]) => placed(point, frame, 0))]);
    const text = scene.labels.map(([text]) => escaped(text));
    return {
      type: "scatter3d", x, y, z, text, hoverinfo: scene.pick ? "text" : "skip", showlegend: false,
      mode: scene.pick ? "markers+text" : "text", marker: { size: 7, color: scene.labels.map(([text]) => PALETTE[text === scene.picked ? 0 : 1]) }, customdata: scene.labels.map(([text]) => text),
      textposition: "top right", textfont: { size: 11, color: colour("--ink") },
    };
  };
  const data = () => {
    const path = columns([Array.from(t, (_, k) => placed([0, 0, 0], scene.moving, k))]);
    const walked = {
      type: "scatter3d", x: path[0], y: path[1], z: path[2], hoverinfo: "name", name: scene.steps ? words.poses : words.path,
      ...(scene.steps ? { mode: "markers", marker: { size: 2, color: PALETTE[2] } }
        : { mode: "lines", line: { width: 2, color: PALETTE[2] } }),
    };
    const still = t.length > 1 ? [walked] : [];
    moving = scene.parts.map((part, k) => [part, k + still.length]).filter(([part]) => !stands(part));
    return [...still, ...scene.parts.map((part) => trace(part, 0)), ...(scene.labels.length ? [named()] : [])];
  };
  const axis = (title, k) => { // with as many ticks as a side of this length has room for
    const lengths = scene.ends.map(([low, high]) => high - low), share = lengths[k] / Math.max(...lengths);
    return { title: { text: title }, range: scene.ends[k], autorange: false, nticks: Math.max(2, Math.round((alone() || narrow.matches ? 4 : 7) * share)) };
  };
  const aspect = () => { // as mode "data" has it, which fails where all points lie in a plane
    const lengths = scene.ends.map(([low, high]) => high - low);
    const [x, y, z] = lengths.map((length) => length / Math.cbrt(lengths[0] * lengths[1] * lengths[2]));
    return { x, y, z };
  };
  const layout = () => {
    const far = alone() ? 1.25 : narrow.matches ? 1.55 : 1.0; // labels need room beside the machine
    const height = alone() ? Math.max(260, innerHeight - div.closest("figure").querySelector(".player").offsetHeight - 8)
      : narrow.matches ? 400 : 560;
    return {
      height, uirevision: "keep", showlegend: !alone(), margin: { l: 0, r: 0, t: alone() ? 0 : 30, b: 0 },
      scene: {
        aspectmode: "manual", aspectratio: aspect(), uirevision: "keep",
        camera: { eye: { x: 1.35 * far, y: -1.6 * far, z: 0.7 * far }, center: { x: 0, y: 0, z: -0.2 } },
        xaxis: axis("x [mm]", 0), yaxis: axis("y [mm]", 1), zaxis: axis("z [mm]", 2),
      },
    };
  };

  const meters = [];
  function listed() { // limits, those first that come closest
    limits.replaceChildren();
    meters.length = 0;
    if (!scene.used) return;
    used = numbers(scene.used.shares);
    const count = scene.used.names.length;
    const most = scene.used.names.map((_, k) => Math.max(...Array.from(t, (_, n) => used[n * count + k])));
    for (const k of most.map((_, k) => k).sort((a, b) => most[b] - most[a]).slice(0, MOST_LIMITS)) {
      const row = document.createElement("div"), name = document.createElement("span");
      const meter = document.createElement("meter"), share = document.createElement("output");
      name.textContent = scene.used.names[k];
      meter.max = 1;
      meter.setAttribute("aria-label", scene.used.names[k]);
      row.append(name, meter, share);
      limits.append(row);
      meters.push([row, meter, share, k]);
    }
  }
  function light() {
    for (const [row, meter, share, k] of meters) {
      const value = used[wanted * scene.used.names.length + k];
      meter.value = value;
      share.textContent = (100 * value).toFixed(0) + " %";
      row.classList.toggle("lit", value >= LIT);
    }
  }

  const label = () => {
    instant.textContent = scene.steps ? `${words.pose} ${wanted + 1} ${words.of} ${t.length}`
      : `${t[wanted].toFixed(2)} ${words.of} ${t[t.length - 1].toFixed(2)} s`.replaceAll(".", words.decimal ?? ".");
    slider.value = String(wanted);
    light();
  };
  async function show(k) {
    wanted = k;
    label();
    if (busy) return;
    busy = true;
    while (shown !== wanted) {
      shown = wanted;
      const shapes = moving.map(([part]) => columns(lines(part, shown)));
      await Plotly.restyle(div, { x: shapes.map((s) => s[0]), y: shapes.map((s) => s[1]), z: shapes.map((s) => s[2]) }, moving.map(([, k]) => k));
    }
    busy = false;
  }
  function frame(now) {
    if (began === null) return;
    const time = t[0] + (now - began) / 1000;
    let k = wanted;
    while (k < t.length - 1 && t[k + 1] <= time) k += 1;
    show(k);
    if (k < t.length - 1) requestAnimationFrame(frame);
    else stop();
  }
  function stop() {
    began = null;
    button.textContent = words.play;
  }
  button.addEventListener("click", () => {
    if (began !== null) { stop(); return; }
    if (wanted >= t.length - 1) wanted = 0;
    began = performance.now() - (t[wanted] - t[0]) * 1000;
    button.textContent = words.pause;
    requestAnimationFrame(frame);
  });
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });

  // Where plotly draws a point of the machine, in pixels of the picture; it has no public function that says so.
  function seen(point) {
    const inner = div._fullLayout.scene._scene, { model, view, projection } = inner.glplot.cameraParams;
    const times = (m, v) => [0, 1, 2, 3].map((row) => m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * v[3]);
    const at = [model, view, projection].reduce((v, m) => times(m, v), [...point.map((x, k) => x * inner.dataScale[k]), 1]);
    const { clientWidth: width, clientHeight: height } = inner.container;
    return [(0.5 + at[0] / at[3] / 2) * width, (0.5 - at[1] / at[3] / 2) * height];
  }
  // A click or a tap chooses the nearest label; a drag turns the machine, and chooses nothing.
  function picking() {
    const still = new Map();
    const place = (event) => {
      const box = div._fullLayout.scene._scene.container.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    const far = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
    div.addEventListener("pointerdown", (event) => still.set(event.pointerId, place(event)), true);
    addEventListener("pointerup", (event) => {
      const from = still.get(event.pointerId), to = place(event);
      still.delete(event.pointerId);
      if (!scene.pick || !from || far(from, to) > HELD) return;
      const ways = scene.labels.map(([, point, frame]) => far(to, seen(placed(point, frame, wanted))));
      const nearest = ways.indexOf(Math.min(...ways));
      if (ways[nearest] <= NEAR) choose(scene.labels[nearest][0]);
    }, true);
    addEventListener("pointercancel", (event) => still.delete(event.pointerId), true);
  }
  // Two fingers zoom, which plotly takes for a drag of the first one.
  function pinching() {
    let before = null;
    const apart = (touches) => Math.hypot(touches[0].clientX - touches[1].clientX, touches[0].clientY - touches[1].clientY);
    for (const kind of ["touchstart", "touchmove"]) {
      div.addEventListener(kind, (event) => {
        if (event.touches.length !== 2) { before = null; return; }
        event.preventDefault();
        event.stopPropagation();
        const inner = div._fullLayout.scene._scene;
        if (kind === "touchstart" || before === null) { before = { apart: apart(event.touches), eye: inner.getCamera().eye }; return; }
        const times = before.apart / Math.max(1, apart(event.touches)), { eye } = before;
        Plotly.relayout(div, { "scene.camera.eye": { x: eye.x * times, y: eye.y * times, z: eye.z * times } });
      }, { capture: true, passive: false });
    }
    div.addEventListener("touchend", () => { before = null; }, true);
  }
  async function choose(name) {
    scene = { ...scene, picked: name };
    parent.postMessage({ picked: name }, "*");
    const marker = { size: 7, color: scene.labels.map(([text]) => PALETTE[text === name ? 0 : 1]) };
    await Plotly.restyle(div, { marker: [marker] }, [div.data.length - 1]);
  }

  async function take(next, said) {
    scene = next;
    words = { ...words, ...said };
    t = numbers(scene.t);
    frames = numbers(scene.frames);
    shown = wanted = 0;
    slider.max = String(t.length - 1);
    stop();
    listed();
    label();
    div.closest("figure").classList.toggle("moves", t.length > 1);
    busy = true;
    div.classList.add("live"); // so that what stands below it has its height
    if (drawn) await Plotly.react(div, data(), { ...layout(), template: template() });
    else {
      await draw(div, data(), layout());
      picking();
      pinching();
    }
    drawn = true;
    busy = false;
  }
  return { take };
}

// Plotly stands on the page compressed; it is read once the text above it has been drawn.
async function load() {
  const packed = atob(document.getElementById("plotly").textContent);
  const bytes = Uint8Array.from(packed, (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.append(script);
}

const breath = () => new Promise((resolve) => { setTimeout(resolve, 0); });

async function drawAll() {
  await new Promise((resolve) => { requestAnimationFrame(() => setTimeout(resolve, 0)); });
  await load();
  let count = 0;
  for (const script of document.querySelectorAll("script[data-plot], script#scene")) { // from top to bottom
    const figure = JSON.parse(script.textContent);
    if (script.id === "scene") await machine(document.getElementById("machine"), figure, figure.words);
    else await draw(document.getElementById("plot-" + script.dataset.plot), figure.data, figure.layout);
    count += 1;
    await breath();
  }
  document.documentElement.dataset.drawn = String(count);
}

function recolour() {
  for (const div of document.querySelectorAll(".plot.js-plotly-plot")) Plotly.relayout(div, { template: template() });
}

// In a frame of the guided page: each scene that it sends is drawn, the newest alone where they come faster.
async function take(next) {
  const fresh = latest === null;
  latest = next;
  if (!fresh) return;
  while (latest !== null) {
    const { scene, words } = latest;
    await machine(document.getElementById("machine"), scene, words);
    document.documentElement.dataset.scenes = String(Number(document.documentElement.dataset.scenes ?? 0) + 1);
    latest = latest.scene === scene ? null : latest;
  }
  parent.postMessage({ drawn: true }, "*");
}
let latest = null;

drawAll().then(() => {
  if (!alone()) return;
  addEventListener("message", (event) => { if (event.source === parent && event.data.scene) take(event.data); });
  parent.postMessage({ ready: true }, "*");
}).catch(() => {
  document.documentElement.dataset.drawn = "pictures"; // this browser cannot draw: the pictures stay
  if (alone()) parent.postMessage({ failed: true }, "*");
});
dark.addEventListener("change", recolour);
