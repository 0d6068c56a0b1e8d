// The film of the windows: draws what the tables tell, image by image; the slider of its player says which.
"use strict";
for (const canvas of document.querySelectorAll("canvas.film")) {
  const DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_", SHADES = 10;
  const film = JSON.parse(canvas.dataset.film), words = JSON.parse(canvas.dataset.words);
  const player = canvas.closest(".player"), slider = player.querySelector("input"), pen = canvas.getContext("2d");
  const color = (name) => getComputedStyle(canvas).getPropertyValue(name).trim();
  const FIELD = 900, BAR = 200;  // what the map shows across, and its scale [mm]

  const write = (text, x, y) => { pen.fillStyle = color("--ink"); pen.fillText(text, x, y); };

  // From above, x to the right, the window in the middle; ellipses hold 95 %.
  function map(shot, left, top, width, height) {
    const scale = Math.min(width, height) / FIELD;
    const middle = (k) => shot.frames.reduce((sum, frame) => sum + frame[k], 0) / shot.frames.length;
    const [middleX, middleY] = [middle(2), middle(3)];
    const at = ([x, y]) => [left + width / 2 + scale * (x - middleX), top + height / 2 - scale * (y - middleY)];
    pen.save();
    pen.beginPath();
    pen.rect(left, top, width, height);
    pen.clip();
    const line = (points, stroke, wide) => {
      pen.beginPath();
      for (const point of points) pen.lineTo(...at(point));
      Object.assign(pen, { strokeStyle: stroke, lineWidth: wide });
      pen.stroke();
    };
    line(film.truth, color("--line"), 5);
    line(shot.frames.map((frame) => frame.slice(2, 4)), color("--c0"), 1.5);
    for (const [id, gone, x, y, xx, xy, yy] of shot.frames) {
      const place = at([x, y]), mean = (xx + yy) / 2, apart = Math.hypot((xx - yy) / 2, xy);
      const radius = (variance) => scale * Math.sqrt(5.99 * Math.max(0, variance));
      Object.assign(pen, { strokeStyle: color(gone ? "--c1" : "--c0"), fillStyle: color(gone ? "--c1" : "--c0"), lineWidth: 1.2 });
      pen.beginPath();
      pen.ellipse(...place, radius(mean + apart), radius(mean - apart), -Math.atan2(2 * xy, xx - yy) / 2, 0, 7);
      pen.stroke();
      pen.beginPath();
      pen.arc(...place, gone ? 5 : 3.5, 0, 7);
      pen.fill();
      line([[x, y], film.truth[id]], color("--ink"), 1);  // how far it is from where it truly was
    }
    pen.restore();
    pen.fillStyle = color("--ink");
    pen.fillRect(left, top + height - 3, scale * BAR, 2);
    write(`${BAR / 1000} m`, left + scale * BAR + 6, top + height);
  }

  // Blocks of a matrix in the rows of H, the stronger the larger; fill-in in the color of what has left.
  function matrix(shot, stage, left, top, side) {
    const first = [0];
    for (const count of shot.rows) first.push(first.at(-1) + count);
    const scale = side / first.at(-1), rows = shot.rows;
    pen.strokeStyle = color("--line");
    pen.lineWidth = 1;
    pen.strokeRect(left, top, side, side);
    for (let k = 0; k < shot[stage].length; k += 3) {
      const [i, j, digit] = [...shot[stage].slice(k, k + 3)].map((letter) => DIGITS.indexOf(letter));
      const fill = digit > SHADES;
      pen.fillStyle = color(fill ? "--c1" : "--c0");
      pen.globalAlpha = 0.15 + 0.85 * (fill ? digit - SHADES : digit) / SHADES;
      for (const [a, b] of i === j ? [[i, j]] : [[i, j], [j, i]]) {
        pen.fillRect(left + scale * first[b], top + scale * first[a], scale * rows[b], scale * rows[a]);
      }
    }
    pen.fillStyle = color(stage === "window" ? "--c1" : "--pale");
    shot.gone.forEach((gone, i) => {
      if (!gone) return;
      pen.globalAlpha = stage === "window" ? 0.35 : 1;
      pen.fillRect(left, top + scale * first[i], side, scale * rows[i]);
      pen.fillRect(left + scale * first[i], top, scale * rows[i], side);
    });
    pen.globalAlpha = 1;
  }

  function draw() {
    const width = player.clientWidth - 32, narrow = width < 640, gap = 14;
    const side = narrow ? (width - gap) / 2 : Math.min(300, (width - 2 * gap) / 3), wide = narrow ? width : width - 2 * (side + gap);
    const each = narrow ? 2 * side + 64 : side + 34;
    if (side <= 0 || wide <= 0) return;  // not laid out yet
    const sharp = devicePixelRatio || 1;
    canvas.width = sharp * width;
    canvas.height = sharp * 2 * each;
    canvas.style.height = `${2 * each}px`;
    pen.scale(sharp, sharp);
    pen.font = `${narrow ? 12 : 14}px system-ui, sans-serif`;
    Object.keys(film.names).forEach((policy, k) => {
      const shot = film.shots[policy][slider.value], top = k * each + 22, below = narrow ? top + side + 30 : top;
      const right = narrow ? 0 : wide + gap;
      write(`${film.names[policy]}: ${words.above}`, 0, top - 6);
      map(shot, 0, top, wide, side);
      ["window", "prior"].forEach((stage, at) => {
        write(words[stage], right + at * (side + gap), below - 6);
        matrix(shot, stage, right + at * (side + gap), below, side);
      });
    });
  }

  const go = (by) => {
    const images = Number(slider.max) + 1;
    slider.value = (Number(slider.value) + by + images) % images;
    slider.dispatchEvent(new Event("input"));
  };
  let playing = null;
  const button = (label, act) => {
    const made = document.createElement("button");
    Object.assign(made, { type: "button", textContent: label, onclick: act });
    slider.after(made);
    return made;
  };
  const stop = () => { clearInterval(playing); playing = null; play.textContent = words.play; };
  button(words.on, () => { stop(); go(1); });
  const play = button(words.play, () => {
    if (playing) return stop();
    playing = setInterval(() => go(1), 200);
    play.textContent = words.pause;
  });
  button(words.back, () => { stop(); go(-1); });
  slider.addEventListener("input", draw);
  addEventListener("resize", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
}
