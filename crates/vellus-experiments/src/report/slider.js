"use strict";
for (const stage of document.querySelectorAll(".stage")) {
  const input = stage.querySelector("input");
  const move = () => {
    stage.style.setProperty("--at", input.value + "%");
    input.setAttribute("aria-valuetext", input.value + " % " + input.dataset.left);
  };
  stage.classList.add("slides");
  input.addEventListener("input", move);
  move();
}
