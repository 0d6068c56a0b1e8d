"use strict";
// Drawing: matrices on a canvas, curves and scenes as SVG. Numbers come in as C++ has given them.

const SPACES = {
  "http://www.w3.org/2000/svg": ["svg", "g", "path", "circle", "ellipse", "line", "rect", "text", "title"],
  "http://www.w3.org/1998/Math/MathML": ["math", "mrow", "mi", "mn", "mo", "msub", "msup", "msubsup", "mfrac", "mtable",
    "mtr", "mtd"],
};
const SPACE = Object.fromEntries(Object.entries(SPACES).flatMap(([space, names]) => names.map(name => [name, space])));

// element("p", {class: "soft"}, "words", child, …)
function element(name, attributes = {}, ...children) {
  const node = SPACE[name] ? document.createElementNS(SPACE[name], name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(key, value);
    else if (value !== undefined && value !== false) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children.filter(child => child !== null && child !== undefined));
  return node;
}

// `key` names it for the tasks, which hide what would give the answer away.
function figure(key, title, caption, ...content) {
  return element("figure", {"data-key": key}, element("h2", {}, ...[title].flat()), ...content,
    element("figcaption", {}, caption));
}

// Four digits, as a table shows them.
function short(value) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value), sign = value < 0 ? "−" : "";
  if (value === 0 || Number.isInteger(value) && size < 1e5) return sign + size;
  return sign + (size >= 1e4 || size < 1e-3 ? size.toExponential(2) : size.toPrecision(4));
}

const powerOfTen = n => "10" + [...String(n)].map(letter => "⁰¹²³⁴⁵⁶⁷⁸⁹"[letter] || "⁻").join("");

// A setting's words: "1e-5" as 10⁻⁵, and a range of such.
const asPowers = words => words.replace(/\b(\d+(?:[.]\d+)?)e[+]?(-?\d+)/g, (_, digits, power) => (digits === "1" ? "" : `${digits} × `) + powerOfTen(power));

function color(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

const DECADES = 8;  // entries so much smaller than the largest are as pale as can be seen

// While two settings are drawn side by side: the range of each axis, and of each matrix' entries, by name; else null.
let common = null;
function commonRange(name, [low, high]) {
  if (!common) return [low, high];
  const [least, most] = common.get(name) ?? [low, high];
  common.set(name, [Math.min(least, low), Math.max(most, high)]);
  return common.get(name);
}

// The variable that holds the row.
function variableAt(variables, row) { return variables.findIndex(one => row >= one.row && row < one.row + one.rows); }

// A matrix that can be worked out on paper shows its numbers.
function writeNumbers(context, M, scale, fill) {
  context.font = `${Math.round(scale / 5)}px sans-serif`;
  [context.textAlign, context.textBaseline] = ["center", "middle"];
  M.values.forEach((value, i) => {
    context.fillStyle = fill && fill.values[i] ? "black" : color("--ink");  // on yellow, by night too
    context.fillText(short(value), scale * (i % M.cols + 0.5), scale * (Math.floor(i / M.cols) + 0.5));
  });
}

const largestOf = M => M.values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

// Blue for positive entries, red for negative ones, stronger the larger; yellow where `fill` says that a zero was filled.
// `tell(row, column)` hears of the entry under the pointer or, by arrow keys, under the cursor, which goes from variable to
// variable; `tell(-1)` that there is none; `act(row, column)` of a click or the Enter key.
function matrix(M, {variables = [], fill = null, label, id, act = null, tell = () => {}, largest = largestOf(M)}) {
  const scale = Math.max(1, Math.floor((M.rows <= 6 ? 840 : 480) / Math.max(M.rows, 1)));
  const canvas = element("canvas", {width: scale * M.cols, height: scale * M.rows, role: "application", "aria-label": label,
    tabindex: 0, id});
  const context = canvas.getContext("2d");
  [, largest] = commonRange(id, [0, largest]);
  const [blue, red, yellow, line] = ["--blue", "--red", "--yellow", "--line"].map(color);
  M.values.forEach((value, i) => {
    if (!value) return;
    const depth = 1 + Math.log10(Math.abs(value) / largest) / DECADES, isFilled = fill && fill.values[i];
    context.globalAlpha = isFilled ? 1 : (0.16 + 0.84 * Math.max(0, depth)) * (M.rows <= 6 ? 0.4 : 1);
    context.fillStyle = isFilled ? yellow : value > 0 ? blue : red;
    context.fillRect(scale * (i % M.cols), scale * Math.floor(i / M.cols), scale, scale);
  });
  context.globalAlpha = 1;
  if (M.rows <= 6) writeNumbers(context, M, scale, fill);
  context.fillStyle = line;
  for (const one of variables.filter(one => one.row > 0 && (one.rows > 1 || M.rows < 12))) {
    context.fillRect(scale * one.row - 1, 0, 2, canvas.height);
    context.fillRect(0, scale * one.row - 1, canvas.width, 2);
  }
  const blocks = variables.length ? variables : Array.from({length: M.rows}, (_, row) => ({row, rows: 1}));
  explore(canvas, [M.rows, M.cols], [blocks, blocks], tell, act);
  return canvas;
}

// Where the arrow keys stand in each grid, by its id: it is drawn anew at every change.
const cursors = new Map();

// A grid of rows × columns, walked through by pointer and by arrow keys; the keys go by blocks: [of rows, of columns].
function explore(node, [rows, columns], blocks, tell, act) {
  const cell = event => {
    const box = node.getBoundingClientRect();
    const at = (offset, size, count) => Math.min(count - 1, Math.max(0, Math.floor(offset / size * count)));
    return [at(event.clientY - box.top, box.height, rows), at(event.clientX - box.left, box.width, columns)];
  };
  if (!cursors.has(node.id)) cursors.set(node.id, [0, 0]);
  const here = cursors.get(node.id).map((block, axis) => Math.min(block, blocks[axis].length - 1));
  const entry = () => here.map((block, axis) => blocks[axis][block].row);
  const step = (axis, by) => {
    here[axis] = Math.min(Math.max(here[axis] + by, 0), blocks[axis].length - 1);
    cursors.set(node.id, here);
    tell(...entry());
  };
  const keys = {ArrowUp: [0, -1], ArrowDown: [0, 1], ArrowLeft: [1, -1], ArrowRight: [1, 1]};
  node.addEventListener("pointermove", event => tell(...cell(event)));
  node.addEventListener("pointerleave", () => tell(-1));
  node.addEventListener("focus", () => { if (node.matches(":focus-visible")) tell(...entry()); });
  node.addEventListener("blur", () => tell(-1));
  node.addEventListener("keydown", event => {
    if (keys[event.key]) step(...keys[event.key]);
    else if (act && ["Enter", " "].includes(event.key)) act(...entry());
    else return;
    event.preventDefault();
  });
  if (!act) return;
  node.classList.add("clicks");
  node.addEventListener("click", event => act(...cell(event)));
}

const [WIDTH, HEIGHT, LEFT, BOTTOM] = [340, 230, 62, 38];  // as narrow as a column, so that the letters keep their size

const LETTER = 15;
const wordWidth = words => LETTER * [...words].reduce((sum, letter) => sum + (letter > "\u2e80" ? 1 : 0.55), 0);

// Curves over whole numbers. A series: {name, values, color, dashed, dots}; on a logarithmic axis what is not positive
// stands at its foot.
function chart({series, log = true, x, y, label}) {
  const shown = series.flatMap(one => one.values).filter(value => value !== null && (!log || value > 0));
  const map = log ? Math.log10 : value => value;
  let low = Math.min(...shown.map(map)), high = Math.max(...shown.map(map));
  if (!shown.length) [low, high] = [0, 1];
  if (log) [low, high] = [Math.floor(low), Math.ceil(high)];
  if (!log) low = 0;
  if (high - low < 1e-12) [low, high] = [low - 1, high + 1];
  [low, high] = commonRange(`${label} y`, [low, high]);
  const [, most] = commonRange(`${label} x`, [0, Math.max(1, ...series.map(one => one.values.length - 1))]);
  const px = i => LEFT + (WIDTH - LEFT - 12) * i / most;
  const py = value => value === null ? null : 22 + (HEIGHT - BOTTOM - 22)
    * (1 - ((log && value <= 0 ? low : map(value)) - low) / (high - low));
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label});
  const ticks = log ? Array.from({length: high - low + 1}, (_, i) => low + i) : [low, Math.round((low + high) / 2), high];
  const every = Math.ceil(ticks.length / 7);
  ticks.filter((_, i) => i % every === 0).forEach(tick => {
    const at = py(log ? 10 ** tick : tick);
    svg.append(element("line", {class: "axis", x1: LEFT, x2: WIDTH - 12, y1: at, y2: at}),
      element("text", {x: LEFT - 5, y: at + 5, "text-anchor": "end"}, log ? powerOfTen(tick) : short(tick)));
  });
  svg.append(element("text", {x: WIDTH - 12, y: HEIGHT - 4, "text-anchor": "end"}, x),
    element("text", {x: LEFT, y: HEIGHT - 21, "text-anchor": "middle"}, "0"),
    element("text", {x: px(most), y: HEIGHT - 21, "text-anchor": "middle"}, String(most)),
    element("text", {x: 4, y: 12}, y));
  let legend = LEFT;
  for (const one of series) {
    const stroke = `var(${one.color})`;
    const points = one.values.map((value, i) => [px(i), py(value)]).filter(point => point[1] !== null);
    if (!one.dots && points.length > 1) {
      svg.append(element("path", {d: "M" + points.map(point => point.join(" ")).join("L"), fill: "none", stroke,
        "stroke-width": 2, "stroke-dasharray": one.dashed ? "5 4" : undefined}));
    }
    points.forEach(([cx, cy]) => svg.append(element("circle", {cx, cy, r: one.dots ? 2.6 : 3.2, fill: stroke})));
    svg.append(element("circle", {cx: legend, cy: 8, r: 4, fill: stroke}),
      element("text", {x: legend + 8, y: 13}, one.name));
    legend += 24 + wordWidth(one.name);
  }
  return svg;
}

// Bars of a vector, poses' rows and landmarks' rows in two colors.
function bars(values, poseRows, label) {
  const [, most] = commonRange(label, [0, Math.max(1e-300, ...values.map(Math.abs))]), middle = HEIGHT / 2;
  const step = (WIDTH - LEFT - 12) / Math.max(values.length, 1);
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label});
  svg.append(element("line", {class: "axis", x1: LEFT, x2: WIDTH - 12, y1: middle, y2: middle}),
    element("text", {x: LEFT - 5, y: 24, "text-anchor": "end"}, short(most)),
    element("text", {x: LEFT - 5, y: middle + 4, "text-anchor": "end"}, "0"));
  values.forEach((value, i) => {
    const size = (middle - 20) * Math.abs(value) / most;
    svg.append(element("rect", {x: LEFT + step * i, y: value > 0 ? middle - size : middle, width: Math.max(1, step * 0.8),
      height: size, fill: `var(${i < poseRows ? "--blue" : "--orange"})`}));
  });
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
