"use strict";
(() => {
  const root = document.documentElement;
  const button = document.querySelector("button.theme");
  // Pages opened from a disk may have no storage.
  const stored = (name, value) => {
    try {
      if (value === undefined) return localStorage.getItem(name);
      localStorage.setItem(name, value);
    } catch { /* then the choice lasts as long as the page */ }
    return value ?? null;
  };
  // A page of the documentation site has a switch of its own.
  if (button) {
    let shown = "auto";
    const show = (choice) => {
      shown = choice;
      if (choice === "auto") delete root.dataset.theme;
      else root.dataset.theme = choice;
      button.textContent = `Colours: ${choice}`;
    };
    show(stored("avsec-theme") ?? "auto");
    button.hidden = false;
    button.addEventListener("click", () => {
      const order = ["auto", "light", "dark"];
      const choice = order[(order.indexOf(shown) + 1) % order.length];
      stored("avsec-theme", choice);
      show(choice);
    });
  }

  const theirs = document.querySelector("button.thesis-values");
  if (theirs && document.querySelector(".theirs, td .thesis")) {
    const besideThesis = (shown) => {
      root.classList.toggle("without-thesis", !shown);
      theirs.setAttribute("aria-pressed", String(shown));
    };
    besideThesis(stored("avsec-thesis") !== "hidden");
    theirs.hidden = false;
    theirs.addEventListener("click", () => {
      const shown = theirs.getAttribute("aria-pressed") !== "true";
      stored("avsec-thesis", shown ? "shown" : "hidden");
      besideThesis(shown);
    });
  }

  const hint = document.createElement("div");
  hint.id = "hint";
  hint.hidden = true;
  document.body.append(hint);
  // Without a pointer they are reached by the keyboard, or by a tap.
  for (const cell of document.querySelectorAll("td[data-hint]")) {
    cell.tabIndex = 0;
    cell.setAttribute("aria-describedby", hint.id);
  }
  const tell = (event) => {
    const target = event.target.closest?.("[data-hint]");
    hint.hidden = !target;
    if (!target) return;
    hint.textContent = target.dataset.hint;
    const place = target.getBoundingClientRect();
    const left = Math.min(place.left + place.width / 2 - hint.offsetWidth / 2, innerWidth - hint.offsetWidth - 8);
    const above = place.top - hint.offsetHeight - 6;
    hint.style.left = `${Math.max(8, left) + scrollX}px`;
    hint.style.top = `${(above < 4 ? place.bottom + 6 : above) + scrollY}px`;
  };
  for (const kind of ["mouseover", "focusin"]) document.addEventListener(kind, tell);
  document.addEventListener("focusout", () => { hint.hidden = true; });
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") hint.hidden = true; });

  const key = (row, column) => {
    const cell = row.cells[column];
    return cell.dataset.key === undefined ? cell.textContent.trim() : Number(cell.dataset.key);
  };
  const compare = (a, b) => (typeof a === "number" && typeof b === "number"
    ? a - b : String(a).localeCompare(String(b), "en", { numeric: true }));

  for (const sheet of document.querySelectorAll(".sortable")) {
    const table = sheet.querySelector("table");
    const body = table.tBodies[0];
    const rows = [...body.rows];
    const count = sheet.querySelector(".count");
    const search = sheet.querySelector("input");
    const picks = [...sheet.querySelectorAll("select")];
    const filter = () => {
      const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0;
      for (const row of rows) {
        const text = row.textContent.toLowerCase();
        const fits = words.every((word) => text.includes(word)) && picks.every(
          (pick) => !pick.value || row.cells[pick.dataset.column].textContent.trim() === pick.value);
        row.hidden = !fits;
        shown += fits;
      }
      count.textContent = `${shown} of ${rows.length} rows`;
    };
    for (const pick of picks) {
      const values = new Set(rows.map((row) => row.cells[pick.dataset.column].textContent.trim()));
      for (const value of values) pick.add(new Option(value, value));
    }
    for (const field of [search, ...picks]) field.addEventListener("input", filter);
    filter();
    table.querySelectorAll("th button").forEach((head) => head.addEventListener("click", () => {
      const column = head.closest("th");
      const down = column.getAttribute("aria-sort") === "ascending";
      for (const other of table.tHead.querySelectorAll("th")) other.removeAttribute("aria-sort");
      column.setAttribute("aria-sort", down ? "descending" : "ascending");
      const index = column.cellIndex;
      rows.sort((a, b) => (down ? -1 : 1) * compare(key(a, index), key(b, index)));
      body.append(...rows);
    }));
  }

  // Paper shows what is folded up; the screen then looks as before.
  let folded = [];
  addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    for (const details of folded) details.open = true;
  });
  addEventListener("afterprint", () => { for (const details of folded) details.open = false; });
})();
