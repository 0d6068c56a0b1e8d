// A click on the head of a column of a .sortable table sorts its rows: numbers as numbers, and then the other way round.
"use strict";
for (const table of document.querySelectorAll(".sortable table")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach(other => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const text = row => row.cells[column].textContent.trim();
      const compare = new Intl.Collator(document.documentElement.lang, { numeric: true }).compare;
      const number = row => Number.parseFloat(text(row).replace(/^[✓✗·] /, ""));
      const rows = [...table.tBodies[0].rows];
      const numeric = rows.every(row => /^([✓✗·] )?[\d.]*\*?$/.test(text(row)));
      const order = numeric ? (a, b) => (number(a) || 0) - (number(b) || 0) : (a, b) => compare(text(a), text(b));
      rows.sort((a, b) => down ? order(b, a) : order(a, b));
      table.tBodies[0].append(...rows);
    });
  });
}
