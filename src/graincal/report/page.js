"use strict";
(() => {
  const plots = JSON.parse(document.getElementById("plots").textContent);
  // A finger that scrolls the page must not zoom the plot that it passes over.
  const dragmode = matchMedia("(pointer: coarse)").matches ? false : "zoom";
  const sizes = new Map();

  // Plots follow their frames, whatever changes these: the window, a turned telephone, paper.
  const follow = (frame) => {
    const size = { width: frame.clientWidth, height: frame.clientHeight };
    const drawn = sizes.get(frame);
    if (!size.width || (drawn.width === size.width && drawn.height === size.height)) return;
    sizes.set(frame, size);
    Plotly.relayout(frame, size);
  };
  const observer = new ResizeObserver((entries) => entries.forEach((entry) => follow(entry.target)));

  for (const [id, { data, layout }] of Object.entries(plots)) {
    const frame = document.getElementById(id);
    const size = { width: frame.clientWidth, height: frame.clientHeight };
    sizes.set(frame, size);
    Plotly.newPlot(frame, data, { ...layout, ...size, dragmode }, { displayModeBar: false });
    observer.observe(frame);
  }

  // A browser lays out for paper too late for the plots, so that they take its measures before and give them back after.
  for (const [event, printing] of [["beforeprint", true], ["afterprint", false]]) {
    addEventListener(event, () => {
      document.documentElement.classList.toggle("printing", printing);
      sizes.forEach((_, frame) => follow(frame));
    });
  }
})();
