"use strict";
// Search and sorting of the cut list; without this script the list is complete and in order.
const table = document.querySelector("#cut-list table");
const body = table.tBodies[0];
const rows = Array.from(body.rows);
const form = document.querySelector(".search");
const count = form.querySelector("output");
const words = new Map(rows.map((row) => [row, row.innerText.toLowerCase()]));

function search(text) {
  const wanted = text.toLowerCase().split(/\s+/).filter(Boolean);
  let shown = 0;
  for (const row of rows) {
    row.hidden = !wanted.every((word) => words.get(row).includes(word));
    shown += !row.hidden;
  }
  count.value = wanted.length ? `${shown} of ${rows.length}` : "";
}

form.hidden = false;
form.addEventListener("submit", (event) => event.preventDefault());
form.querySelector("input").addEventListener("input", (event) => search(event.target.value));

const heads = Array.from(table.tHead.rows[0].cells);
heads.forEach((head, column) => {
  if (head.textContent === "edges") return;
  const button = document.createElement("button");
  button.type = "button";
  button.append(...head.childNodes);
  head.append(button);
  const key = (row) => row.cells[column].textContent;
  const compare =
    head.className === "number"
      ? (a, b) => parseFloat(key(a)) - parseFloat(key(b))
      : (a, b) => (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : 0);
  button.addEventListener("click", () => {
    const up = head.getAttribute("aria-sort") !== "ascending";
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    rows.sort((a, b) => (up ? compare(a, b) : compare(b, a)));
    body.append(...rows);
  });
});
