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

// Lines of the machine's parts, whose points are given in frames that move: rows of (R p) of each frame, in mm.
function machine(div, scene) {
  const t = numbers(scene.t), frames = numbers(scene.frames), size = 12 * scene.moving;
  const placed = (point, frame, k) => {
    if (frame === BASE) return point;
    const from = size * k + 12 * (frame - 1), [u, v, w] = point;
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
  const path = columns([Array.from(t, (_, k) => placed([0, 0, 0], scene.moving, k))]);
  const walked = {
    type: "scatter3d", x: path[0], y: path[1], z: path[2], hoverinfo: "name", name: scene.steps ? "poses" : "path",
    ...(scene.steps ? { mode: "markers", marker: { size: 2, color: PALETTE[2] } }
      : { mode: "lines", line: { width: 2, color: PALETTE[2] } }),
  };
  const data = [walked, ...scene.parts.map((part) => trace(part, 0))];
  const moving = scene.parts.map((part, k) => [part, k + 1]).filter(([part]) => !stands(part));
  const axis = (title, range) => ({ title: { text: title }, range, autorange: false });
  const far = narrow.matches ? 1.55 : 1.0; // labels need room beside the machine
  const layout = {
    height: narrow.matches ? 400 : 560, uirevision: "keep", margin: { l: 0, r: 0, t: 30, b: 0 },
    scene: {
      aspectmode: "data", camera: { eye: { x: 1.35 * far, y: -1.6 * far, z: 0.7 * far }, center: { x: 0, y: 0, z: -0.2 } },
      xaxis: axis("x [mm]", scene.ends[0]), yaxis: axis("y [mm]", scene.ends[1]), zaxis: axis("z [mm]", scene.ends[2]),
    },
  };

  const slider = document.getElementById("scrub"), button = document.getElementById("play");
  const instant = document.getElementById("instant");
  slider.max = String(t.length - 1);
  let shown = 0, wanted = 0, busy = true, began = null;

  const label = () => {
    instant.textContent = scene.steps ? `pose ${wanted + 1} of ${t.length}`
      : `${t[wanted].toFixed(2)} of ${t[t.length - 1].toFixed(2)} s`;
    slider.value = String(wanted);
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
    button.textContent = "Play";
  }
  button.addEventListener("click", () => {
    if (began !== null) { stop(); return; }
    if (wanted >= t.length - 1) wanted = 0;
    began = performance.now() - (t[wanted] - t[0]) * 1000;
    button.textContent = "Pause";
    requestAnimationFrame(frame);
  });
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  label();
  return draw(div, data, layout).then(() => { busy = false; });
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
    if (script.id === "scene") await machine(document.getElementById("machine"), figure);
    else await draw(document.getElementById("plot-" + script.dataset.plot), figure.data, figure.layout);
    count += 1;
    await breath();
  }
  document.documentElement.dataset.drawn = String(count);
}

function recolour() {
  for (const div of document.querySelectorAll(".plot.js-plotly-plot")) Plotly.relayout(div, { template: template() });
}

drawAll().catch(() => {
  document.documentElement.dataset.drawn = "pictures"; // this browser cannot draw: the pictures stay
});
dark.addEventListener("change", recolour);
