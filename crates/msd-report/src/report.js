"use strict";
// Points of the figure and rows of the tables are the same trials: one shows the other, and a
// point its method. Without this, the browser shows the titles of the points by itself.
const tip = document.getElementById("tip");
const of = (row) => document.querySelectorAll(`[data-row="${row}"]`);
const circles = document.querySelectorAll("circle[data-row]");
const mark = (row, shown) => of(row).forEach((part) => part.classList.toggle("shown", shown));
for (const circle of circles) {
  const title = circle.querySelector("title");
  const said = title.textContent;
  const drawing = circle.ownerSVGElement;
  circle.setAttribute("aria-label", said);
  title.remove();
  circle.addEventListener("pointerenter", () => {
    const { left, right, top, bottom } = circle.getBoundingClientRect();
    tip.textContent = said;
    tip.hidden = false;
    const { width, height } = tip.getBoundingClientRect();
    const beside = right + width + 12 < innerWidth ? right + 6 : Math.max(left - width - 6, 4);
    const upright = Math.min((top + bottom - height) / 2, innerHeight - height - 4);
    tip.style.left = `${beside}px`;
    tip.style.top = `${Math.max(upright, 4)}px`;
    drawing.dataset.method = circle.dataset.method;
    mark(circle.dataset.row, true);
  });
  circle.addEventListener("pointerleave", () => {
    tip.hidden = true;
    delete drawing.dataset.method;
    mark(circle.dataset.row, false);
  });
}
for (const row of document.querySelectorAll("tr[data-row]")) {
  const point = document.querySelector(`circle[data-row="${row.dataset.row}"]`);
  if (!point) continue;
  row.addEventListener("pointerenter", () => {
    point.ownerSVGElement.dataset.method = point.dataset.method;
    mark(row.dataset.row, true);
  });
  row.addEventListener("pointerleave", () => {
    delete point.ownerSVGElement.dataset.method;
    mark(row.dataset.row, false);
  });
}
addEventListener("beforeprint", () => {
  document.querySelectorAll("details").forEach((folded) => { folded.open = true; });
});
