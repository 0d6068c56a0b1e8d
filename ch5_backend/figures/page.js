// What scrolls can be reached by keys, and the report's figures answer. Without this script everything is there, only all at once.
"use strict";
document.documentElement.classList.add("js");

// On paper nothing is folded.
addEventListener("beforeprint", () => { for (const more of document.querySelectorAll("figcaption details")) more.open = true; });

// A slider shows what bears its number: <… class="at" data-at="3"> and the rows of its tables.
for (const player of document.querySelectorAll(".player")) {
  const [input] = player.getElementsByTagName("input"), [output] = player.getElementsByTagName("output");
  const labels = JSON.parse(player.dataset.labels);
  const show = () => {
    for (const old of player.querySelectorAll(".on")) old.classList.remove("on");
    for (const now of player.querySelectorAll(`[data-at="${input.value}"]`)) now.classList.add("on");
    output.textContent = labels[input.value];
    input.setAttribute("aria-valuetext", labels[input.value]);
  };
  input.addEventListener("input", show);
  player.querySelector(".control").hidden = false;
  show();
}

// Words in which H_pm and J_i are set as in a book. See formulas in page.py.
function setFormulas(place, words) {
  const pieces = words.split(/([A-Za-z])_([A-Za-z]{1,2})/);  // text, letter, index, text, …
  place.replaceChildren(...pieces.map((piece, at) => {
    if (at % 3 === 0) return piece;
    const set = document.createElement(at % 3 === 1 ? "i" : "sub");
    set.textContent = piece;
    return set;
  }));
}

// A matrix tells which edges and vertices made the block under the pointer, the finger or the arrow keys.
function exploreMatrix(svg, figure) {
  const vertices = JSON.parse(svg.dataset.vertices);  // [name, first row, rows]
  const cursor = svg.querySelector(".cursor"), made = figure.querySelector(".made");
  const words = new Map();
  for (const block of svg.querySelectorAll(".block")) {
    words.set(block.dataset.block, [block, block.querySelector("title").textContent]);
    block.querySelector("title").remove();  // else the browser would show it over the matrix
  }
  const empty = (row, column) => svg.dataset.empty.replace("{row}", row).replace("{column}", column);
  let here = [0, 0];
  const show = (row, column) => {
    here = [row, column];
    const [rowName, y, height] = vertices[row], [columnName, x, width] = vertices[column];
    const [block, text] = words.get(`${row} ${column}`) ?? [null, empty(rowName, columnName)];
    for (const [name, value] of Object.entries({ x, y, width, height })) cursor.setAttribute(name, value);
    setFormulas(made, text);
    for (const old of figure.querySelectorAll(".map .on")) old.classList.remove("on");
    const parts = block ? block.dataset.parts.split(" ") : [];
    for (const part of [...parts, `v${row}`, `v${column}`]) figure.querySelector(`.map .${part}`)?.classList.add("on");
  };
  const indexAt = (at) => vertices.findIndex(([, first, rows]) => at < first + rows);
  const point = (event) => {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const row = indexAt(y), column = indexAt(x);
    if (row >= 0 && column >= 0 && x >= 0 && y >= 0) show(row, column);
  };
  const moves = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
  const inside = (index) => Math.min(Math.max(index, 0), vertices.length - 1);
  svg.addEventListener("pointermove", point);
  svg.addEventListener("pointerdown", point);
  svg.addEventListener("focus", () => show(...here));
  svg.addEventListener("keydown", (event) => {
    const move = moves[event.key];
    if (!move) return;
    event.preventDefault();
    show(inside(here[0] + move[0]), inside(here[1] + move[1]));
  });
  svg.setAttribute("tabindex", "0");
  svg.setAttribute("role", "application");
}

for (const figure of document.querySelectorAll(".explore")) {
  for (const svg of figure.querySelectorAll("svg.blocks")) exploreMatrix(svg, figure);
}

// What can be scrolled sideways must be reached without a mouse, and only that.
function markScrollers() {
  for (const box of document.querySelectorAll(".scroll")) {
    const wide = box.scrollWidth > box.clientWidth || box.scrollHeight > box.clientHeight;
    const marks = { tabindex: "0", role: "group", "aria-label": document.body.dataset.scrolls };
    for (const [name, value] of Object.entries(marks)) wide ? box.setAttribute(name, value) : box.removeAttribute(name);
  }
}
addEventListener("resize", markScrollers);
addEventListener("load", markScrollers);
markScrollers();
