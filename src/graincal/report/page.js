"use strict";
(() => {
  const plots = JSON.parse(document.getElementById("plots").textContent);
  // A finger that scrolls the page must not zoom the plot that it passes over.
  const dragmode = matchMedia("(pointer: coarse)").matches ? false : "zoom";
  const sizes = new Map();

  // A folded plot has no size, and is drawn when it is opened.
  const draw = (frame, size) => {
    const { data, layout } = plots[frame.id];
    sizes.set(frame, size);
    Plotly.newPlot(frame, data, { ...layout, ...size, dragmode }, { displayModeBar: false });
  };

  // Plots follow their frames, whatever changes these: the window, a turned telephone, paper.
  const follow = (frame) => {
    const size = { width: frame.clientWidth, height: frame.clientHeight };
    const drawn = sizes.get(frame);
    if (!size.width) return;
    if (!drawn) return draw(frame, size);
    if (drawn.width === size.width && drawn.height === size.height) return;
    sizes.set(frame, size);
    Plotly.relayout(frame, size);
  };
  const observer = new ResizeObserver((entries) => entries.forEach((entry) => follow(entry.target)));

  for (const id of Object.keys(plots)) {
    const frame = document.getElementById(id);
    sizes.set(frame, undefined);
    follow(frame);
    observer.observe(frame);
  }

  // A browser lays out for paper too late for the plots, so that they take its measures before and give them back after.
  // On paper everything is open.
  const closed = [];
  const unfold = (printing) => {
    if (printing) closed.push(...document.querySelectorAll("details:not([open])"));
    closed.forEach((each) => (each.open = printing));
    if (!printing) closed.length = 0;
  };
  for (const [event, printing] of [["beforeprint", true], ["afterprint", false]]) {
    addEventListener(event, () => {
      unfold(printing);
      document.documentElement.classList.toggle("printing", printing);
      sizes.forEach((_, frame) => follow(frame));
    });
  }
})();
