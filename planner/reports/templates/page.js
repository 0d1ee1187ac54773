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
  return Plotly.newPlot(div, data, { ...layout, template: template() }, config);
}

// Typed arrays stand in the data as base64; the scene is ours to decode, the figures are plotly's.
function numbers(packed) {
  const raw = Uint8Array.from(atob(packed.bdata), (c) => c.charCodeAt(0));
  return new Float32Array(raw.buffer);
}

// Points of {P}, in mm, in a pose (x, y, z in mm, roll, pitch, yaw in rad): R = Rz(yaw) Ry(pitch) Rx(roll).
function placed(points, pose) {
  const [x, y, z, a, b, c] = pose;
  const [ca, sa, cb, sb, cc, sc] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b), Math.cos(c), Math.sin(c)];
  return points.map(([u, v, w]) => [
    x + cc * cb * u + (cc * sb * sa - sc * ca) * v + (cc * sb * ca + sc * sa) * w,
    y + sc * cb * u + (sc * sb * sa + cc * ca) * v + (sc * sb * ca - cc * sa) * w,
    z - sb * u + cb * sa * v + cb * ca * w,
  ]);
}

const closed = (points) => [...points, points[0]];
const segments = (from, to) => from.flatMap((p, k) => [p, to[k], [null, null, null]]);
const apart = (lines) => lines.flatMap((line) => [...line, [null, null, null]]);
const columns = (points) => [0, 1, 2].map((k) => points.map((p) => p[k]));

function machine(div, scene) {
  const t = numbers(scene.t), poses = numbers(scene.poses);
  const pose = (k) => poses.subarray(6 * k, 6 * k + 6);
  const moving = (k) => {
    const joints = placed(scene.platform, pose(k));
    const shapes = [segments(scene.base, joints), closed(joints)];
    if (scene.lower.length) {
      const lower = placed(scene.lower, pose(k)), upper = placed(scene.upper, pose(k));
      shapes.push(segments(lower, upper), closed(upper));
    }
    if (scene.tools.length) shapes.push(apart(scene.tools.map((line) => placed(line, pose(k)))));
    shapes.push([Array.from(pose(k).subarray(0, 3))]);
    return shapes.map(columns);
  };
  const trace = (xyz, name, style) => ({
    type: "scatter3d", mode: "lines", x: xyz[0], y: xyz[1], z: xyz[2], name, hoverinfo: "name", ...style,
  });
  const styles = [
    ["struts", { line: { width: 7, color: PALETTE[0] } }],
    ["platform", { line: { width: 8, color: PALETTE[1] } }],
    ["sensors", { line: { width: 5, color: PALETTE[4] } }],
    ["frame", { line: { width: 5, color: PALETTE[4] }, showlegend: false }],
  ];
  const tip = ["origin of {P}", { mode: "markers", marker: { size: 4, color: PALETTE[2] }, showlegend: false }];
  const tools = ["tools", { line: { width: 4, color: PALETTE[5] } }];
  const named = [...styles.slice(0, scene.lower.length ? 4 : 2), ...(scene.tools.length ? [tools] : []), tip];
  const path = columns(Array.from(t, (_, k) => Array.from(pose(k).subarray(0, 3))));
  const still = [
    trace(columns(closed(scene.base)), "base", { line: { width: 6, color: PALETTE[3] } }),
    trace(path, scene.steps ? "poses" : "path", scene.steps
      ? { mode: "markers", marker: { size: 2, color: PALETTE[2] } } : { line: { width: 2, color: PALETTE[2] } }),
  ];
  if (scene.boxes.length) still.push(trace(columns(apart(scene.boxes)), "kept out", { line: { width: 3, color: "#888888" } }));
  const data = [...still, ...moving(0).map((xyz, k) => trace(xyz, ...named[k]))];
  const axis = (title, range) => ({ title: { text: title }, range, autorange: false });
  const far = narrow.matches ? 1.55 : 1.0; // labels need room beside the machine
  const layout = {
    height: 560, uirevision: "keep", margin: { l: 0, r: 0, t: 30, b: 0 },
    scene: {
      aspectmode: "data", camera: { eye: { x: 1.35 * far, y: -1.6 * far, z: 0.7 * far }, center: { x: 0, y: 0, z: -0.2 } },
      xaxis: axis("x [mm]", scene.range[0]), yaxis: axis("y [mm]", scene.range[1]), zaxis: axis("z [mm]", scene.range[2]),
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
      const shapes = moving(shown), index = shapes.map((_, i) => still.length + i);
      await Plotly.restyle(div, { x: shapes.map((s) => s[0]), y: shapes.map((s) => s[1]), z: shapes.map((s) => s[2]) }, index);
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

drawAll().catch((error) => {
  for (const div of document.querySelectorAll(".plot:empty")) div.textContent = "This browser cannot draw the figure: " + error.message;
});
dark.addEventListener("change", recolour);
for (const [event, paper] of [["beforeprint", true], ["afterprint", false]]) {
  window.addEventListener(event, () => { document.documentElement.classList.toggle("paper", paper); recolour(); });
}
