// The program beside the part: a click on the surface gives the line that cut it, a click on a line shows its path; scales of the colors.
const bench = (async () => {
  'use strict';
  const view = await partView;
  const pane = document.getElementById('listing'), said = document.getElementById('said');
  const say = (text) => { if (said) said.textContent = text; };
  const stored = await inflated('listing-data');
  const files = stored ? JSON.parse(new TextDecoder().decode(stored)) : [];

  // Lines of all files one under the other: a number over all files, its own number, its text
  const rows = [];
  files.forEach((file) => {
    if (!file.text.length) return;
    if (files.filter((f) => f.text.length).length > 1) rows.push({ title: file.name });
    let last = 0;
    file.text.forEach((text, k) => {
      const number = file.numbers.length ? file.numbers[k] : k + 1;
      if (number > last + 1) rows.push({ gap: number - last - 1 });
      rows.push({ id: file.base + number, number, text });
      last = number;
    });
  });
  const placeOf = (id) => {
    const file = files.filter((f) => f.base < id).pop();
    return file ? { name: file.name, number: id - file.base } : null;
  };

  // Path: stretches by line
  const packed = await inflated('path-data'), stretches = new Map();
  let points = null;
  if (packed) {
    const head = new DataView(packed.buffer), count = head.getUint32(0, true), total = head.getUint32(4, true);
    const low = [8, 12, 16].map((o) => head.getFloat32(o, true)), size = [20, 24, 28].map((o) => head.getFloat32(o, true));
    const ids = new Uint32Array(count), sizes = new Uint32Array(count), axis = new Uint32Array(total);
    let at = numbersAt(packed, numbersAt(packed, 32, count, ids), count, sizes);
    points = new Float32Array(3 * total);
    for (let k = 0; k < 3; k++) {
      at = numbersAt(packed, at, total, axis);
      for (let i = 0; i < total; i++) points[3 * i + k] = low[k] + size[k] * axis[i] / 65535;
    }
    let first = 0;
    ids.forEach((id, k) => {
      const length = sizes[k] >> 1;
      if (!stretches.has(id)) stretches.set(id, []);
      stretches.get(id).push([first, length, sizes[k] & 1]);
      first += length;
    });
  }
  const segments = (list) => {
    const count = list.reduce((sum, s) => sum + Math.max(s[1] - 1, 0), 0), out = new Float32Array(7 * count);
    let k = 0;
    for (const [first, length, rapid] of list) {
      for (let i = first; i < first + length - 1; i++) {
        out.set(points.subarray(3 * i, 3 * i + 6), 7 * k);
        out[7 * k++ + 6] = rapid;
      }
    }
    return out;
  };

  // The listing: only rows in sight are elements
  const HEIGHT = 19;
  let chosen = 0, playing = 0;
  const heard = [];
  const rowOf = new Map(rows.map((r, k) => [r.id, k]));
  const fill = pane && pane.querySelector('.fill');
  const paint = () => {
    if (!pane) return;
    const first = Math.max(0, Math.floor(pane.scrollTop / HEIGHT) - 8), last = Math.min(rows.length, first + Math.ceil(pane.clientHeight / HEIGHT) + 16);
    fill.style.height = `${rows.length * HEIGHT}px`;
    fill.replaceChildren(...rows.slice(first, last).map((row, k) => {
      const element = document.createElement('div');
      element.style.top = `${(first + k) * HEIGHT}px`;
      if (row.title || row.gap) {
        element.className = 'row title';
        element.textContent = row.title || `… ${row.gap} lines`;
        return element;
      }
      element.className = 'row' + (row.id === chosen ? ' chosen' : '') + (row.id === playing ? ' playing' : '') + (found.has(row.id) ? ' ' + found.get(row.id) : '');
      element.setAttribute('role', 'option');
      element.setAttribute('aria-selected', row.id === chosen);
      element.id = `row-${row.id}`;
      element.dataset.line = row.id;
      const number = document.createElement('span');
      number.className = 'number';
      number.textContent = row.number;
      element.append(number, row.text);
      return element;
    }));
    if (chosen) pane.setAttribute('aria-activedescendant', `row-${chosen}`);
  };
  const found = new Map();
  document.querySelectorAll('[data-finding-line]').forEach((e) => { if (!found.has(Number(e.dataset.findingLine))) found.set(Number(e.dataset.findingLine), e.dataset.severity); });
  const intoSight = (id) => {
    if (!pane || !rowOf.has(id)) return;
    const top = rowOf.get(id) * HEIGHT;
    if (top < pane.scrollTop || top > pane.scrollTop + pane.clientHeight - 2 * HEIGHT) pane.scrollTop = top - pane.clientHeight / 2;
  };
  const show = (id, frame) => {
    chosen = id;
    intoSight(id);
    paint();
    const list = stretches.get(id) || [];
    if (view && points) {
      view.setPath('chosen', segments(list));
      if (frame && list.length) {
        const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
        for (const [first, length] of list) for (let i = first; i < first + length; i++) for (let k = 0; k < 3; k++) {
          low[k] = Math.min(low[k], points[3 * i + k]);
          high[k] = Math.max(high[k], points[3 * i + k]);
        }
        view.frame(low, high);
      }
    }
    return list.length;
  };
  const words = (id) => { const p = placeOf(id); return p ? `${p.name}, line ${p.number}` : 'no line'; };
  if (pane) {
    if (!rows.length) { pane.hidden = true; }
    pane.addEventListener('scroll', () => requestAnimationFrame(paint));
    pane.addEventListener('click', (e) => {
      const row = e.target.closest('[data-line]');
      if (!row) return;
      const id = Number(row.dataset.line), count = show(id, true);
      say(count ? `${words(id)}: its path is drawn` : `${words(id)} moves nothing`);
      heard.forEach((tell) => tell(id, false));
    });
    pane.addEventListener('dblclick', (e) => {
      const row = e.target.closest('[data-line]');
      if (row) heard.forEach((tell) => tell(Number(row.dataset.line), true));
    });
    pane.addEventListener('keydown', (e) => {
      const way = { ArrowDown: 1, ArrowUp: -1, PageDown: 20, PageUp: -20 }[e.key];
      if (!way && e.key !== 'Enter') return;
      e.preventDefault();
      let k = rowOf.has(chosen) ? rowOf.get(chosen) : -1;
      if (way) k = Math.min(Math.max(k + way, 0), rows.length - 1);
      while (rows[k] && !rows[k].id && k < rows.length - 1) k += 1;
      if (rows[k] && rows[k].id) {
        const count = show(rows[k].id, e.key === 'Enter');
        say(count ? `${words(rows[k].id)}: its path is drawn` : `${words(rows[k].id)} moves nothing`);
      }
    });
    new ResizeObserver(paint).observe(pane);
    paint();
  }
  if (view) view.onClick(async (hit) => {
    if (!hit) { say('Nothing there.'); return; }
    const run = await runData, line = run ? run.lineOf(hit.block) : 0;
    const at = hit.point.map((v, k) => 'XYZ'[k] + ' ' + v.toFixed(2)).join(' ');
    const off = hit.value === null ? '' : `, ${Math.abs(hit.value) < 0.1 ? (1e3 * hit.value).toFixed(1) + ' µm' : hit.value.toFixed(3) + ' mm'} from the design`;
    if (hit.face) say(`${at}: in the material, on the plane of the section`);
    else if (line) { show(line, false); say(`${at}${off}: cut by ${words(line)}`); heard.forEach((tell) => tell(line, false, hit.block)); }
    else say(`${at}${off}: skin of the raw stock`);
  });

  // Links of findings: place on the part, line of the program
  document.querySelectorAll('[data-mark]').forEach((link) => link.addEventListener('click', () => { if (view) view.choose(link.dataset.mark); }));
  document.querySelectorAll('[data-to-line]').forEach((link) => link.addEventListener('click', () => {
    const id = Number(link.dataset.toLine);
    show(id, !link.dataset.mark);
    say(words(id));
  }));
  const whole = document.querySelector('[data-path]');
  if (whole && view && points) {
    whole.hidden = false;
    whole.addEventListener('click', () => {
      const on = whole.getAttribute('aria-pressed') !== 'true';
      whole.setAttribute('aria-pressed', on);
      view.setPath('all', on ? segments([...stretches.values()].flat()) : null);
    });
  }

  // Scales of gouge and excess
  const form = document.getElementById('scales');
  if (form && view && view.data.scales) {
    const fields = ['gouge', 'excess'].map((name) => form.elements[name]), to = form.elements.to;
    const label = (mm) => mm < 0.1 ? `${+(1e3 * mm).toPrecision(3)} µm` : `${+mm.toPrecision(4)} mm`;
    const apply = () => {
      const range = fields.map((f, k) => { const v = Number(f.value); return v > 0 && isFinite(v) ? v : view.data.scales[k][0]; });
      view.setRange(...range);
      document.querySelector('[data-low]').textContent = `-${label(range[0])} gouge`;
      document.querySelector('[data-high]').textContent = `${label(range[1])} material left`;
    };
    fields.forEach((f) => f.addEventListener('input', () => { to.value = 'own'; apply(); }));
    to.addEventListener('change', () => {
      const k = { shown: 0, points: 1, largest: 2, tolerance: 3 }[to.value];
      if (k !== undefined) fields.forEach((f, side) => { f.value = +view.data.scales[side][k].toPrecision(3); });
      apply();
    });
    form.addEventListener('submit', (e) => e.preventDefault());
  }
  document.documentElement.dataset.bench = 'ready';
  window.proveoutPage = { view, state: () => ({ chosen, ...(view ? view.state() : {}) }), rows: rows.length, stretches: stretches.size };
  return {
    say, words,
    // The listing shows the line of the moment
    follow(id) {
      if (id === playing) return;
      playing = id;
      intoSight(id);
      paint();
    },
    // Number over all files of a line of the file that is chosen, or of the first
    lineNamed(number) {
      const file = files.filter((f) => f.base < (chosen || playing)).pop() || files[0];
      return file && number > 0 ? file.base + number : 0;
    },
    onLine(tell) { heard.push(tell); },
  };
})();
