"use strict";
// Drawing: matrices on a canvas, curves and scenes as SVG. Numbers come in as C++ has given them.

const SVG = "http://www.w3.org/2000/svg";

// element("p", {class: "soft"}, "words", child, …)
function element(name, attributes = {}, ...children) {
  const node = ["svg", "g", "path", "circle", "line", "rect", "text", "title"].includes(name)
    ? document.createElementNS(SVG, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(key, value);
    else if (value !== undefined && value !== false) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children.filter(child => child !== null && child !== undefined));
  return node;
}

function figure(title, caption, ...content) {
  return element("figure", {}, element("h2", {}, title), ...content, element("figcaption", {}, caption));
}

// Four digits, as a table shows them.
function short(value) {
  if (value === null || value === undefined) return "–";
  if (value === 0 || Number.isInteger(value) && Math.abs(value) < 1e5) return String(value);
  const size = Math.abs(value);
  return size >= 1e4 || size < 1e-3 ? value.toExponential(2) : value.toPrecision(4);
}

function color(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

const DECADES = 8;  // entries so much smaller than the largest are as pale as can be seen

// The variable that holds the row.
function variableAt(variables, row) { return variables.findIndex(one => row >= one.row && row < one.row + one.rows); }

// A matrix that can be worked out on paper shows its numbers.
function writeNumbers(context, M, scale) {
  context.fillStyle = color("--ink");
  context.font = `${Math.round(scale / 5)}px sans-serif`;
  [context.textAlign, context.textBaseline] = ["center", "middle"];
  M.values.forEach((value, i) => {
    context.fillText(short(value), scale * (i % M.cols + 0.5), scale * (Math.floor(i / M.cols) + 0.5));
  });
}

// Blue for positive entries, red for negative ones, stronger the larger; orange where `fill` says that a zero was filled.
function matrix(M, {variables = [], fill = null, label, click = null, tell = null}) {
  const scale = Math.max(1, Math.floor((M.rows <= 6 ? 840 : 480) / Math.max(M.rows, 1)));
  const canvas = element("canvas", {width: scale * M.cols, height: scale * M.rows, role: "img", "aria-label": label});
  const context = canvas.getContext("2d");
  const largest = M.values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const [blue, red, orange, line] = ["--blue", "--red", "--fill", "--line"].map(color);
  M.values.forEach((value, i) => {
    if (!value) return;
    const depth = 1 + Math.log10(Math.abs(value) / largest) / DECADES;
    context.globalAlpha = (0.16 + 0.84 * Math.max(0, depth)) * (M.rows <= 6 ? 0.4 : 1);
    context.fillStyle = fill && fill.values[i] ? orange : value > 0 ? blue : red;
    context.fillRect(scale * (i % M.cols), scale * Math.floor(i / M.cols), scale, scale);
  });
  context.globalAlpha = 1;
  if (M.rows <= 6) writeNumbers(context, M, scale);
  context.fillStyle = line;
  for (const one of variables.filter(one => one.row > 0 && (one.rows > 1 || M.rows < 12))) {
    context.fillRect(scale * one.row - 1, 0, 2, canvas.height);
    context.fillRect(0, scale * one.row - 1, canvas.width, 2);
  }
  const cell = event => {
    const box = canvas.getBoundingClientRect();
    const at = (offset, size, count) => Math.min(count - 1, Math.max(0, Math.floor(offset / size * count)));
    return [at(event.clientY - box.top, box.height, M.rows), at(event.clientX - box.left, box.width, M.cols)];
  };
  if (tell) canvas.addEventListener("pointermove", event => tell(...cell(event)));
  if (click) {
    canvas.classList.add("clicks");
    canvas.addEventListener("click", event => {
      const [row, column] = cell(event);
      click(variableAt(variables, Math.max(row, column) === row ? row : column));
    });
  }
  return canvas;
}

const [WIDTH, HEIGHT, LEFT, BOTTOM] = [420, 260, 52, 34];

// Curves over whole numbers. A series: {name, values, color, dashed, dots}; on a logarithmic axis what is not positive
// stands at its foot.
function chart({series, log = true, x, y, label}) {
  const shown = series.flatMap(one => one.values).filter(value => value !== null && (!log || value > 0));
  const map = log ? Math.log10 : value => value;
  let low = Math.min(...shown.map(map)), high = Math.max(...shown.map(map));
  if (!shown.length) [low, high] = [0, 1];
  if (log) [low, high] = [Math.floor(low), Math.ceil(high)];
  if (high - low < 1e-12) [low, high] = [low - 1, high + 1];
  const most = Math.max(1, ...series.map(one => one.values.length - 1));
  const px = i => LEFT + (WIDTH - LEFT - 12) * i / most;
  const py = value => value === null ? null : 22 + (HEIGHT - BOTTOM - 22)
    * (1 - ((log && value <= 0 ? low : map(value)) - low) / (high - low));
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label});
  const ticks = log ? Array.from({length: high - low + 1}, (_, i) => low + i) : [low, (low + high) / 2, high];
  const every = Math.ceil(ticks.length / 7);
  ticks.filter((_, i) => i % every === 0).forEach(tick => {
    const at = py(log ? 10 ** tick : tick);
    svg.append(element("line", {class: "axis", x1: LEFT, x2: WIDTH - 12, y1: at, y2: at}),
      element("text", {x: LEFT - 5, y: at + 4, "text-anchor": "end"}, log ? `1e${tick}` : short(tick)));
  });
  svg.append(element("text", {x: WIDTH - 12, y: HEIGHT - 4, "text-anchor": "end"}, x),
    element("text", {x: LEFT, y: HEIGHT - 18, "text-anchor": "middle"}, "0"),
    element("text", {x: px(most), y: HEIGHT - 18, "text-anchor": "middle"}, String(most)),
    element("text", {x: 4, y: 12}, y));
  let legend = 110;
  for (const one of series) {
    const stroke = `var(${one.color})`;
    const points = one.values.map((value, i) => [px(i), py(value)]).filter(point => point[1] !== null);
    if (!one.dots && points.length > 1) {
      svg.append(element("path", {d: "M" + points.map(point => point.join(" ")).join("L"), fill: "none", stroke,
        "stroke-width": 2, "stroke-dasharray": one.dashed ? "5 4" : undefined}));
    }
    points.forEach(([cx, cy]) => svg.append(element("circle", {cx, cy, r: one.dots ? 2.6 : 3.2, fill: stroke})));
    svg.append(element("circle", {cx: legend, cy: 8, r: 4, fill: stroke}),
      element("text", {x: legend + 8, y: 12}, one.name));
    legend += 22 + 13 * [...one.name].reduce((sum, letter) => sum + (letter > "\u2e80" ? 1 : 0.55), 0);
  }
  return svg;
}

// Bars of a vector, poses' rows and landmarks' rows in two colors.
function bars(values, poseRows, label) {
  const most = Math.max(1e-300, ...values.map(Math.abs)), middle = HEIGHT / 2;
  const step = (WIDTH - LEFT - 12) / Math.max(values.length, 1);
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label});
  svg.append(element("line", {class: "axis", x1: LEFT, x2: WIDTH - 12, y1: middle, y2: middle}),
    element("text", {x: LEFT - 5, y: 24, "text-anchor": "end"}, short(most)),
    element("text", {x: LEFT - 5, y: middle + 4, "text-anchor": "end"}, "0"));
  values.forEach((value, i) => {
    const size = (middle - 20) * Math.abs(value) / most;
    svg.append(element("rect", {x: LEFT + step * i, y: value > 0 ? middle - size : middle, width: Math.max(1, step * 0.8),
      height: size, fill: `var(${i < poseRows ? "--blue" : "--red"})`}));
  });
  return svg;
}

// Camera frames and points from above. A layer: {name, color, frames: [{p, R}], points: [[x, y, z]], path, hollow}
function scene(layers, label) {
  const all = layers.flatMap(one => [...(one.frames || []).map(frame => frame.p), ...(one.points || [])])
    .filter(p => p.every(Number.isFinite));
  const range = axis => [Math.min(...all.map(p => p[axis])), Math.max(...all.map(p => p[axis]))];
  const [[x0, x1], [y0, y1]] = [range(0), range(1)];
  const size = Math.min((WIDTH - 40) / Math.max(x1 - x0, 1e-9), (HEIGHT - 56) / Math.max(y1 - y0, 1e-9));
  const at = p => [WIDTH / 2 + size * (p[0] - (x0 + x1) / 2), (HEIGHT + 20) / 2 - size * (p[1] - (y0 + y1) / 2)];
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label});
  let legend = 10;
  for (const one of layers) {
    const paint = one.hollow ? {fill: "none", stroke: `var(${one.color})`, "stroke-width": 1.3} : {fill: `var(${one.color})`};
    const frames = (one.frames || []).filter(frame => frame.p.every(Number.isFinite));
    (one.points || []).filter(p => p.every(Number.isFinite)).forEach(p => {
      const [cx, cy] = at(p);
      svg.append(element("circle", {cx, cy, r: one.hollow ? 4 : 2.4, ...paint}));
    });
    if (frames.length > 1) {
      svg.append(element("path", {d: "M" + frames.map(frame => at(frame.p).join(" ")).join("L"), fill: "none",
        stroke: `var(${one.color})`, "stroke-width": 1.5, "stroke-dasharray": one.hollow ? "4 3" : undefined}));
    }
    frames.forEach(frame => {  // a triangle whose tip is the camera's x axis
      const [cx, cy] = at(frame.p);
      if (!frame.R) return;
      const [ux, uy] = [frame.R[0], -frame.R[3]];
      const corner = (along, across) => `${cx + along * ux - across * uy} ${cy + along * uy + across * ux}`;
      svg.append(element("path", {d: `M${corner(9, 0)}L${corner(-5, 5)}L${corner(-5, -5)}Z`, ...paint}));
    });
    svg.append(element("circle", {cx: legend, cy: 10, r: 4, ...paint}), element("text", {x: legend + 8, y: 14}, one.name));
    legend += 22 + 13 * [...one.name].reduce((sum, letter) => sum + (letter > "\u2e80" ? 1 : 0.55), 0);
  }
  return svg;
}

// Without a word above the first column, that column names the rows.
function table(heads, rows, now = -1) {
  const cells = row => row.map((cell, i) => element(...(i === 0 && !heads[0] ? ["th", {scope: "row"}] : ["td", {}]),
    cell instanceof Node || typeof cell === "string" ? cell : short(cell)));
  return element("div", {class: "scroll", tabindex: 0}, element("table", {},
    heads.some(Boolean) ? element("thead", {}, element("tr", {},
      ...heads.map(head => head ? element("th", {scope: "col"}, head) : element("td")))) : null,
    element("tbody", {}, ...rows.map((row, i) => element("tr", {class: i === now ? "now" : undefined}, ...cells(row))))));
}
