// Uses everything in the report as a reader would; the value is what was shown and said.
"use strict";
(() => {
  // Every position of a slider: its words, and how many curves and rows it shows.
  function useSlider(player) {
    const input = player.querySelector("input"), output = player.querySelector("output"), seen = [];
    const canvas = player.querySelector("canvas"), pictures = new Set();
    for (let at = 0; at <= Number(input.max); ++at) {
      input.value = at;
      input.dispatchEvent(new Event("input"));
      pictures.add(canvas?.toDataURL());
      const rows = [...player.querySelectorAll("tbody tr")].filter((row) => row.offsetHeight > 0);
      seen.push({ words: output.textContent, spoken: input.getAttribute("aria-valuetext"),
                  rows: rows.map((row) => row.textContent), curves: player.querySelectorAll("path.on").length });
    }
    return { label: input.labels[0].textContent, seen, pictures: pictures.size };
  }

  // The words on each block of a matrix, by arrow keys from the first one, row after row.
  function useMatrix(svg) {
    const made = svg.closest(".explore").querySelector(".made"), words = [];
    const vertices = JSON.parse(svg.dataset.vertices).length;
    const press = (key) => svg.dispatchEvent(new KeyboardEvent("keydown", { key, cancelable: true }));
    svg.focus();
    for (let row = 0; row < vertices; ++row) {
      for (let column = 0; column < vertices; ++column) {
        words.push([made.textContent, document.querySelectorAll(".map .edge.on").length]);
        if (column + 1 < vertices) press("ArrowRight");
      }
      for (let column = 1; column < vertices; ++column) press("ArrowLeft");
      press("ArrowDown");
    }
    return words;
  }

  // A finger in the middle of a block.
  function tap(svg, row, column) {
    const [[, y, height], [, x, width]] = [row, column].map((index) => JSON.parse(svg.dataset.vertices)[index]);
    const at = new DOMPoint(x + width / 2, y + height / 2).matrixTransform(svg.getScreenCTM());
    svg.dispatchEvent(new PointerEvent("pointerdown", { clientX: at.x, clientY: at.y, bubbles: true }));
    return svg.closest(".explore").querySelector(".made").textContent;
  }

  const [H, S] = document.querySelectorAll("svg.blocks");
  return { sliders: [...document.querySelectorAll(".player")].map(useSlider), H: useMatrix(H), S: useMatrix(S), tapped: tap(H, 1, 2) };
})()
