// Numbers, warnings, versions and the text of the case.

function card(holder, title, long) {
  const element = holder.appendChild(Object.assign(document.createElement("div"), { className: long ? "card long" : "card" }));
  element.append(Object.assign(document.createElement("h2"), { textContent: title }));
  return element;
}

// With signs that do not end a line.
const signed = (text) => text.replace(/(^|[\s(=e])-(?=[\d.])/g, "$1−");

// Rows of all runs side by side: names that any has, a column of values for each.
function table(holder, runs, rowsOf) {
  const names = [...new Set(runs.flatMap((run) => rowsOf(run).map(([name]) => name)))];
  const body = document.createElement("table");
  if (runs.length > 1) {
    body.className = "several";
    const head = body.createTHead().insertRow();
    for (const name of ["", ...runs.map((run) => run.name)]) head.append(Object.assign(document.createElement("th"), { textContent: name }));
  }
  const rows = body.createTBody();
  for (const name of names) {
    const row = rows.insertRow();
    row.append(Object.assign(document.createElement("th"), { textContent: name }));
    for (const run of runs) row.insertCell().textContent = signed((rowsOf(run).find(([other]) => other === name) || ["", "–"])[1]);
  }
  holder.append(body);
}

export function showFacts(holder, runs) {
  table(card(holder, "Numbers"), runs, (run) => run.numbers);
  const side = holder.appendChild(Object.assign(document.createElement("div"), { className: "side" }));
  const said = card(side, "Warnings");
  for (const run of runs) {
    if (runs.length > 1) said.append(Object.assign(document.createElement("p"), { className: "missing", textContent: run.name }));
    if (run.warnings.length) {
      const list = said.appendChild(Object.assign(document.createElement("ul"), { className: "warnings" }));
      for (const text of run.warnings) list.append(Object.assign(document.createElement("li"), { textContent: signed(text) }));
    } else said.append(Object.assign(document.createElement("p"), { className: "missing", textContent: "None." }));
  }
  if (runs.some((run) => Object.keys(run.versions).length)) {
    table(card(side, "Versions"), runs, (run) => Object.entries(run.versions));
  }
  for (const run of runs) {
    if (!run.case) continue;
    const element = side.appendChild(Object.assign(document.createElement("div"), { className: "card long" }));
    const details = element.appendChild(document.createElement("details"));
    const name = runs.length > 1 ? `Case file of ${run.name}` : "Case file";
    details.append(Object.assign(document.createElement("summary"), { textContent: name }));
    details.append(Object.assign(document.createElement("pre"), { textContent: run.case }));
  }
}
