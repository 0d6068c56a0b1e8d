"use strict";
// Formulas, set by the browser as MathML. They are written as on the slides: "S = H_pp − H_pm H_mm^−1 H_mp".

const PIECE = /([\p{L}∂]+|\d[\d.]*(?:×10\^[−\d]+)?)((?:_(?:\{[^}]*\}|[\p{L}\d]+))?)((?:\^(?:\{[^}]*\}|[−\p{L}\d′]+))?)|(\S)/gu;

function script(words) {
  const bare = words.slice(1).replace(/[{}]/g, "");
  return element("mrow", {}, ...formulaPieces(bare));
}

function formulaPieces(words) {
  return [...words.matchAll(PIECE)].map(([, base, below, above, sign]) => {
    if (sign) return element("mo", {stretchy: "false"}, sign);
    const [number, ten] = base.split("×10^");
    if (ten) return element("mrow", {}, element("mn", {}, number), element("mo", {}, "×"),
      element("msup", {}, element("mn", {}, "10"), element("mn", {}, ten)));
    const node = /^\d/.test(base) ? element("mn", {}, base) : element("mi", {class: base.length > 1 && "long"}, base);
    if (below && above) return element("msubsup", {}, node, script(below), script(above));
    if (below) return element("msub", {}, node, script(below));
    return above ? element("msup", {}, node, script(above)) : node;
  });
}

// A formula from words and nodes, such as columns, in a row.
function formula(...parts) {
  return element("math", {displaystyle: "true"}, element("mrow", {}, ...parts.flatMap(part =>
    typeof part === "string" ? formulaPieces(part) : [part])));
}

// A number in a formula: 1.25e−7 is 1.25 × 10⁻⁷.
function number(value) {
  const [digits, power] = short(value).replaceAll("-", "−").split("e");
  return power ? `${digits}×10^${power.replace("+", "")}` : digits;
}

// Negative ones in brackets, to stand behind a sign.
const inner = value => value < 0 ? `(${number(value)})` : number(value);

const fraction = (above, below) => element("mfrac", {}, element("mrow", {}, ...formulaPieces(above)),
  element("mrow", {}, ...formulaPieces(below)));

// A matrix of numbers, row by row, between two lines, which need no font with tall brackets.
function brackets(values, columns) {
  const rows = Array.from({length: values.length / columns}, (_, i) => values.slice(columns * i, columns * (i + 1)));
  return element("mtable", {}, ...rows.map(row => element("mtr", {},
    ...row.map(value => element("mtd", {}, ...formulaPieces(number(value)))))));
}

const lines = (...formulas) => element("div", {class: "formulas scroll", tabindex: 0, role: "group",
  "aria-label": text("formulas")}, ...formulas.map(one => element("div", {}, one)));

// Words with formulas between backquotes.
function rich(key, values) {
  return say(key, values).split("`").map((part, i) => i % 2 ? formula(part) : part);
}
