"use strict";
(() => {
  const at = (id) => document.getElementById(id);
  const order = ["responses", "latest", "emulator", "convergence", "samples", "run_times"];

  const duration = (seconds) => {
    if (seconds === null || seconds === undefined) return "-";
    if (seconds <= 0) return "0 s";
    if (seconds < 60) return `${seconds < 1 ? seconds.toPrecision(1) : Math.round(seconds)} s`;
    return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
  };
  const clock = (iso) => (iso ? new Date(iso).toLocaleString() : "-");

  // All text is put in as text: nothing that a campaign says is read as HTML.
  const element = (name, text, kind = "") => {
    const made = document.createElement(name);
    made.textContent = text;
    if (kind) made.className = kind;
    return made;
  };
  const facts = (pairs) => at("facts").replaceChildren(...pairs.map(([term, text]) => {
    const row = document.createElement("div");
    row.append(element("dt", term), element("dd", text));
    return row;
  }));

  const ofLook = (look) => (look ? " of the first look" : "");

  const toEnd = (seconds) => {
    const said = [];
    if (seconds && seconds.as_most_go !== null) said.push(`about ${duration(seconds.as_most_go)} as most campaigns go`);
    if (seconds && seconds.at_most !== null) said.push(`at most about ${duration(seconds.at_most)}`);
    return said.length ? [`to the end ${said.join(", ")}`] : [];
  };

  const showStatus = (status) => {
    const look = status.first_look && status.first_look.state !== "finished" ? status.first_look : null;
    const { iteration: now, seconds_left: left } = look || status;
    const round = `${status.method === "posterior" ? "batch" : "iteration"}${ofLook(look)}`;
    document.title = `${status.state}: ${status.folder}`;
    at("title").textContent = status.experiments.join(", ");
    at("state").textContent = `${status.folder}: ${status.state}, ${status.evaluations} evaluations, ${status.failures} failed`;
    const pairs = [["began", clock(status.started)], ["last ended", clock(status.updated)], ["run time", `${duration(status.seconds)} of all evaluations together`]];
    if (look) pairs.push(["first look", `${look.state}, before the campaign itself: ${look.evaluations} evaluations, ${look.failures} failed`]);
    if (now && !status.stopped_by) {
      pairs.push([round, `${now.index}: ${now.evaluated} of ${now.samples} evaluated, ${now.failed} failed`]);
      const times = [...(left ? [`about ${duration(left)} in this ${round}`] : []), ...toEnd(status.seconds_to_end)];
      pairs.push(["time left", times.join(", ") || "not known yet"]);
    }
    const soFar = status.settled ? "" : " so far";
    const each = (values, write) => Object.entries(values).map(([name, value]) => `${name} ${write(value)} ${status.units[name]}`.trim()).join("; ");
    if (status.posterior) pairs.push([`90 % intervals${soFar}`, each(status.posterior.interval_90, ([low, high]) => `${low.toPrecision(4)} to ${high.toPrecision(4)}`)]);
    if (status.answer) pairs.push([`answer${soFar}`, each(status.answer.theta, (value) => value.toPrecision(4))]);
    if (status.stopped_because) pairs.push(["ended", status.stopped_because]);
    if (status.next_command) pairs.push(["go on with", status.next_command]);
    facts(pairs);
    const kinds = Object.entries((look || status).failure_kinds).map(([kind, count]) => `${kind}: ${count}`);
    at("failures").textContent = kinds.join(", ") || "None.";
  };

  const showEvaluations = ({ total, rows, look }) => {
    at("evaluations-of").textContent = `Evaluations${ofLook(look)}`;
    at("shown").textContent = rows.length < total ? `The last ${rows.length} of ${total}.` : `${total} asked for.`;
    at("evaluations").replaceChildren(...rows.map((each) => {
      const row = element("tr", "", each.state.replace(" ", "-"));
      const link = element("td", "");
      if (each.printed) {
        const anchor = element("a", "look");
        anchor.href = `/printed/${each.sample}/${each.experiment}`;
        anchor.target = "_blank";
        anchor.rel = "noopener";
        link.append(anchor);
      }
      row.append(element("td", each.sample), element("td", each.name), element("td", each.state), element("td", clock(each.ended)));
      row.append(element("td", duration(each.seconds), "n"), element("td", each.attempts, "n"), link, element("td", each.error));
      return row;
    }));
  };

  const place = (figure) => {
    const rank = (each) => (order.indexOf(each.id) + order.length + 1) % (order.length + 1);
    const next = [...at("figures").children].find((each) => rank(each) > rank(figure));
    at("figures").insertBefore(figure, next || null);
  };

  // The server has escaped what stands in a figure's own HTML; frames that are there already are drawn in again, so that nothing jumps.
  const showFigure = ({ name, html, plots, look }) => {
    const title = `Figures${ofLook(look)}`;
    if (at("figures-of").textContent !== title) at("figures").replaceChildren();
    at("figures-of").textContent = title;
    const fresh = new DOMParser().parseFromString(html, "text/html").querySelector("figure");
    const frames = (figure) => [...figure.querySelectorAll(".plot")].map((frame) => frame.id).join();
    const drawn = document.getElementById(name);
    if (drawn && frames(drawn) === frames(fresh)) {
      for (const part of ["h3", ".key", "figcaption"]) {
        const [old, young] = [drawn.querySelector(part), fresh.querySelector(part)];
        if (old && young) old.replaceWith(young);
        else if (young) drawn.querySelector("h3").after(young);
      }
    } else {
      if (drawn) drawn.remove();
      place(fresh);
    }
    for (const [id, { data, layout }] of Object.entries(plots)) {
      Plotly.react(at(id), data, layout, { displayModeBar: false, responsive: true });
    }
  };

  const troubles = new Map();
  const say = (of, text) => {
    troubles.set(of, text);
    at("trouble").textContent = [...troubles.values()].filter(Boolean).join(" ");
    at("trouble").hidden = !at("trouble").textContent;
  };

  const events = new EventSource("/events");
  const on = (kind, show) => events.addEventListener(kind, (event) => show(JSON.parse(event.data)));
  on("status", showStatus);
  on("evaluations", showEvaluations);
  on("figure", showFigure);
  on("trouble", ({ of, text }) => say(of, text));
  events.onerror = () => say("server", "graincal watch does not answer. This page goes on when it does.");
  events.onopen = () => say("server", "");
})();
