// Tables that sort by a click on a header and filter by a text; sections that unfold when a link leads into them, and for print.
(() => {
  'use strict';
  const unfold = (element) => {
    for (let at = element; at; at = at.parentElement) if (at.tagName === 'DETAILS') at.open = true;
  };
  const follow = () => {
    const element = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!element) return;
    unfold(element);
    document.querySelectorAll('.here').forEach((e) => e.classList.remove('here'));
    element.classList.add('here');
    element.scrollIntoView({ block: 'nearest' });
  };
  window.addEventListener('hashchange', follow);
  document.addEventListener('click', (e) => {
    const link = e.target.closest('a[href^="#"]');
    // A second click on the same link changes no address.
    if (link && link.getAttribute('href') === location.hash) follow();
  });
  follow();

  // Print shows everything, and leaves the page as it was.
  let folded = [];
  window.addEventListener('beforeprint', () => {
    folded = [...document.querySelectorAll('details:not([open])')];
    folded.forEach((d) => { d.open = true; });
  });
  window.addEventListener('afterprint', () => folded.forEach((d) => { d.open = false; }));
  document.querySelectorAll('[data-fold]').forEach((b) => b.addEventListener('click', () => {
    document.querySelectorAll(b.dataset.within).forEach((d) => { d.open = b.dataset.fold === 'open'; });
  }));

  // A cell sorts by its number with the unit taken into account, or by its text.
  const factors = { µm: 1e-3, mm: 1, m: 1e3, s: 1, min: 60, h: 3600, 'mm³': 1e-3, 'cm³': 1 };
  const keyOf = (cell) => {
    if (!cell) return -Infinity;
    if (cell.dataset.sort) return Number(cell.dataset.sort);
    const text = cell.textContent.trim().replace(/\u202f/g, '').replace(/\u2212/g, '-');
    // A time with colons: hours and minutes, or minutes, before the seconds
    const clock = text.match(/^(?:(\d+):)?(\d+):(\d+(?:\.\d+)?) (?:h|min)/);
    if (clock) return 3600 * Number(clock[1] || 0) + 60 * Number(clock[2]) + Number(clock[3]);
    const parts = [...text.matchAll(/(-?\d+(?:\.\d+)?(?:e-?\d+)?)\s*(µm|mm³|cm³|mm|min|m|s|h)?(?![\w/])/g)];
    if (!parts.length || !/^(line |± |T)?-?\d/.test(text)) return text === '' || text === '–' ? -Infinity : text.toLowerCase();
    return Number(parts[0][1]) * (factors[parts[0][2]] || 1);
  };
  const compare = (a, b) => typeof a === typeof b ? (a < b ? -1 : a > b ? 1 : 0) : typeof a === 'number' ? -1 : 1;
  document.querySelectorAll('table.sorts').forEach((table) => {
    const body = table.tBodies[0], rows = [...body.rows];
    if (rows.length < 2) return;
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      if (!head.textContent.trim()) return;
      const button = document.createElement('button');
      button.className = 'sort';
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener('click', () => {
        const down = head.getAttribute('aria-sort') === 'ascending';
        [...table.tHead.rows[0].cells].forEach((h) => h.removeAttribute('aria-sort'));
        head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
        const sorted = rows.map((row, k) => [keyOf(row.cells[column]), k, row]);
        sorted.sort((a, b) => (down ? -1 : 1) * compare(a[0], b[0]) || a[1] - b[1]);
        body.append(...sorted.map((s) => s[2]));
      });
    });
    if (rows.length < 6) return;
    const field = document.createElement('input');
    field.type = 'search';
    field.placeholder = `Filter ${rows.length} rows`;
    field.setAttribute('aria-label', 'Show rows that contain this text');
    field.className = 'filter no-print';
    field.addEventListener('input', () => {
      const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
      rows.forEach((row) => { const text = row.textContent.toLowerCase(); row.hidden = !words.every((w) => text.includes(w)); });
    });
    table.closest('.scroll').before(field);
  });
  // Causes of findings by a text, too.
  document.querySelectorAll('[data-filters]').forEach((field) => field.addEventListener('input', () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    document.querySelectorAll(field.dataset.filters).forEach((e) => {
      const text = e.textContent.toLowerCase();
      e.hidden = !words.every((w) => text.includes(w));
    });
    // What is found is seen.
    if (words.length) document.querySelectorAll('details.rest').forEach((d) => { d.open = true; });
  }));
})();
