"use strict";
// The scene as a picture of x and y: cameras, landmarks, and who sees whom. Cameras and landmarks can be dragged.

const WORLD = {left: -9.4, right: 5.4, low: -5.4, high: 9.4};  // the course's scene, with room to drag [m]
const SIDE = 480;
const PIXELS = SIDE / (WORLD.right - WORLD.left);              // for a meter
const toPicture = p => [PIXELS * (p[0] - WORLD.left), PIXELS * (WORLD.high - p[1])];
const isFinitePoint = p => p.every(one => Number.isFinite(one));

function legend(layers) {
  let at = 10;
  return layers.flatMap(one => {
    const x = at;
    at += 24 + wordWidth(one.name);
    return [element("circle", {cx: x, cy: 10, r: 4, ...paintOf(one)}), element("text", {x: x + 8, y: 15}, one.name)];
  });
}

const paintOf = one => one.hollow ? {fill: "none", stroke: `var(${one.color})`, "stroke-width": 1.5}
  : {fill: `var(${one.color})`, stroke: "none"};

// A bar in the lower left, of 1, 2 or 5 times a power of ten and at most a fifth of the picture.
function scaleBar(width, height, pixels) {
  const most = 0.2 * width / pixels, decade = 10 ** Math.floor(Math.log10(most));
  const length = decade * [5, 2, 1].find(one => one * decade <= most);
  return [element("path", {class: "scale", d: `M10 ${height - 6}h${pixels * length}`}),
    element("text", {x: 10, y: height - 12}, `${parseFloat(length.toPrecision(1))} m`)];
}

// A triangle whose tip is the camera's x axis.
function cameraShape([x, y], R) {
  const [ux, uy] = [R[0], -R[3]];
  const corner = (along, across) => `${x + along * ux - across * uy} ${y + along * uy + across * ux}`;
  return `M${corner(11, 0)}L${corner(-6, 6)}L${corner(-6, -6)}Z`;
}

// A layer: {name, color, frames: [{p, R}], points: [[x, y, z]], hollow}. `rays`: [[landmark, frame], …] of `truth`.
// `drag`: {layer, move(kind, number, dx, dy)} makes the items of that layer handles.
function scene(layers, {label, truth, rays = [], drag = null}) {
  const svg = element("svg", {viewBox: `0 0 ${SIDE} ${SIDE + 16}`, role: "group", "aria-label": label, class: "scene"});
  const place = element("g", {transform: "translate(0 16)"});
  for (const [k, n] of rays) {
    const [[x1, y1], [x2, y2]] = [truth.points[k], truth.frames[n].p].map(toPicture);
    place.append(element("line", {class: "ray", "data-landmark": k, "data-pose": n, x1, y1, x2, y2}));
  }
  const items = (layer, kind, list, draw) => list.forEach((one, n) => {
    if (!isFinitePoint(one.p || one)) return;
    const node = draw(toPicture(one.p || one), one);
    node.dataset.item = `${kind} ${n}`;
    if (drag && drag.layer === layer) makeHandle(node, kind, n, one.p || one, drag);
    place.append(node);
  });
  for (const layer of layers) {
    const paint = paintOf(layer);
    items(layer, "landmark", layer.points || [], ([cx, cy]) => element("circle", {cx, cy, r: layer.hollow ? 5 : 3.4, ...paint}));
    const frames = (layer.frames || []).filter(frame => isFinitePoint(frame.p));
    if (frames.length > 1) {
      place.append(element("path", {d: "M" + frames.map(frame => toPicture(frame.p).join(" ")).join("L"), fill: "none",
        stroke: `var(${layer.color})`, "stroke-width": 1.5, "stroke-dasharray": layer.hollow ? "4 3" : undefined}));
    }
    items(layer, "pose", layer.frames || [], (at, frame) => element("path", {d: cameraShape(at, frame.R), ...paint}));
  }
  svg.append(place, ...legend(layers), ...scaleBar(SIDE, SIDE + 16, PIXELS));
  return svg;
}

const STEP = 0.25;  // of an arrow key [m]

function makeHandle(node, kind, number, p, {move}) {
  node.classList.add("handle");
  const words = element("title", {}, say(`${kind}.n`, {n: number}));
  node.append(words);
  for (const [key, value] of Object.entries({tabindex: 0, role: "button", id: `handle-${kind}-${number}`,
    "aria-label": say("handle", {name: say(`${kind}.n`, {n: number}), x: p[0].toFixed(2), y: p[1].toFixed(2)})})) {
    node.setAttribute(key, value);
  }
  const keys = {ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP]};
  node.addEventListener("keydown", event => {
    if (!keys[event.key]) return;
    event.preventDefault();
    move(kind, number, ...keys[event.key]);
  });
  // A finger on a handle drags it; on the empty scene it scrolls the page. touch-action is not heard on SVG's shapes.
  node.addEventListener("touchstart", event => event.preventDefault(), {passive: false});
  node.addEventListener("pointerdown", event => {
    event.preventDefault();
    const scale = node.ownerSVGElement.getScreenCTM().a * PIXELS;  // of the screen, for a meter
    let [x, y] = [event.clientX, event.clientY];
    // The picture is drawn anew on the way, so the page listens and not the item.
    const onMove = next => {
      move(kind, number, (next.clientX - x) / scale, (y - next.clientY) / scale);
      [x, y] = [next.clientX, next.clientY];
    };
    const onEnd = () => {
      removeEventListener("pointermove", onMove);
      document.documentElement.classList.remove("dragging");
    };
    document.documentElement.classList.add("dragging");
    addEventListener("pointermove", onMove);
    for (const end of ["pointerup", "pointercancel"]) addEventListener(end, onEnd, {once: true});
  });
}

// A map of positions whose size is not known before.
function trajectories(layers, label) {
  const all = layers.flatMap(one => one.points);
  const range = axis => commonRange(`${label} ${axis}`, [Math.min(...all.map(p => p[axis])), Math.max(...all.map(p => p[axis]))]);
  const [[x0, x1], [y0, y1]] = [range(0), range(1)];
  const size = Math.min((WIDTH - 40) / Math.max(x1 - x0, 0.1), (HEIGHT - 56) / Math.max(y1 - y0, 0.1));
  const at = p => [WIDTH / 2 + size * (p[0] - (x0 + x1) / 2), (HEIGHT + 20) / 2 - size * (p[1] - (y0 + y1) / 2)];
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label});
  for (const one of layers.filter(one => one.points.length > 1)) {
    svg.append(element("path", {d: "M" + one.points.map(p => at(p).join(" ")).join("L"), fill: "none",
      stroke: `var(${one.color})`, "stroke-width": 1.5, "stroke-dasharray": one.hollow ? "4 3" : undefined}));
  }
  svg.append(...legend(layers), ...scaleBar(WIDTH, HEIGHT, size));
  return svg;
}

// Lights up what the rows and columns of a block belong to; nothing for no variables.
function light(box, variables) {
  const keys = variables.filter(Boolean).map(one => `${one.kind} ${one.number}`);
  for (const node of box.querySelectorAll("[data-item]")) node.classList.toggle("lit", keys.includes(node.dataset.item));
  const poses = keys.filter(key => key.startsWith("pose")).map(key => key.slice(5));
  const landmarks = keys.filter(key => key.startsWith("landmark")).map(key => key.slice(9));
  const rays = [...box.querySelectorAll(".ray")];
  // Poses meet in the landmarks that both see.
  const shared = poses.length > 1 && poses[0] !== poses[1]
    ? rays.filter(ray => poses.every(n => n === "0" || rays.some(other => other.dataset.landmark === ray.dataset.landmark
      && other.dataset.pose === n))).map(ray => ray.dataset.landmark) : null;
  for (const ray of rays) {
    const {landmark, pose} = ray.dataset;
    ray.classList.toggle("lit", keys.length > 0 && (landmarks.length ? landmarks.includes(landmark)
      && (!poses.length || poses.includes(pose)) : poses.includes(pose) && (!shared || shared.includes(landmark))));
  }
}
