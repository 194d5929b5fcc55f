"use strict";
(() => {
  const boxes = document.querySelector("#show-boxes");
  boxes?.addEventListener("input", () => {
    document.querySelector("#scenes").classList.toggle("without-boxes", !boxes.checked);
  });
})();
