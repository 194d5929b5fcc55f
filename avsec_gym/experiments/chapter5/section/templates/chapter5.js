"use strict";
(() => {
  const boxes = document.querySelector("#show-boxes");
  boxes?.addEventListener("input", () => {
    boxes.closest("section").classList.toggle("without-boxes", !boxes.checked);
  });
  const play = document.querySelector("#play-drives");
  if (!play) return;
  const drives = play.closest("section").querySelectorAll("svg.drive");
  const set = () => drives.forEach((drive) => {
    if (play.checked) drive.unpauseAnimations();
    else { drive.setCurrentTime(0); drive.pauseAnimations(); }
  });
  play.checked = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  play.addEventListener("input", set);
  set();
})();
