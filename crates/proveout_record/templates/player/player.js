// The bar under the part: time, single blocks, jumps; what the machine does at that moment.
const player = (async () => {
  'use strict';
  const [view, run, desk] = [await partView, await runData, await bench];
  const bar = document.getElementById('player');
  if (!view || !run || !bar) return null;
  const { data, steps } = run, find = (name) => bar.querySelector(`[data-${name}]`);
  const kinematics = kinematicsOf(data.kinematics), coloring = coloringOf(view, run);
  const end = Math.max(data.end, steps.end[steps.count - 1] || 0);
  const slider = find('time'), now = bar.querySelector('.now'), play = find('play');
  const shown = { machine: 'clear', fixtures: true, design: false };
  // `cursor`: steps that are done; `at` the end of the run is the part as judged
  const state = { time: end, cursor: steps.count, stepped: true, playing: false, fixed: 'part', moment: -1, marked: [1, 0] };
  let bodies = null, stock = null, loading = null;

  const ready = () => loading ??= (async () => {
    bodies = bodiesOf(view, run, await inflated('player-meshes'));
    stock = stockOf(view, await inflated('player-stock'));
  })();
  const atEnd = () => state.time >= end - 1e-9;
  const current = () => Math.min(Math.max(state.stepped ? state.cursor - 1 : state.cursor, 0), steps.count - 1);

  // Words of the moment
  const two = (v) => String(v).padStart(2, '0');
  const clockOf = (t) => { const h = Math.floor(t / 3600), m = Math.floor(t / 60) % 60; return `${h}:${two(m)}:${(t % 60).toFixed(2).padStart(5, '0')}`; };
  const cells = new Map();
  const cell = (name, value) => {
    if (!cells.has(name)) {
      const box = document.createElement('div'), term = document.createElement('dt'), text = document.createElement('dd');
      term.textContent = name;
      box.append(term, text);
      now.append(box);
      cells.set(name, text);
    }
    const text = cells.get(name);
    if (text.textContent !== value) text.textContent = value;
  };
  const tell = () => {
    const k = current(), q = valuesAt(run.joint, state.time), load = data.loads ? valuesAt(run.load, state.time) : [];
    cell(`Time, of ${clockOf(end)}`, clockOf(state.time));
    cell('Block', `${k + 1} of ${steps.count}${data.stride > 1 ? `, ${data.stride} each` : ''}`);
    cell('Line', desk.words(steps.line[k]));
    const feed = valuesAt(run.feed, state.time)[0], asked = run.rapid(k) ? 'rapid' : steps.feed[k] ? `of ${steps.feed[k].toFixed(0)}` : '';
    cell('Feed, mm/min', `${feed.toFixed(0)} ${asked}`.trim());
    const time = steps.end[k] - run.begin(k);
    cell('Removal, mm³/s', time > 0 ? (steps.volume[k] / time).toFixed(1) : '0');
    data.kinematics.joints.forEach((j, i) => cell(`${j.name}, ${j.unit}`, q[i].toFixed(3) + (data.loads ? ` (${load[i].toFixed(0)} %)` : '')));
    const tool = bodies ? data.tools[bodies.toolAt(state.time, k)] : null;
    cell('Tool', tool ? tool.name : '–');
    const operation = data.jumps.operations[countUpTo(operationTimes, state.time) - 1];
    cell('Operation', operation ? operation.text : '–');
    cell('Stock as at', atEnd() ? 'the end, as judged' : stock ? clockOf(stock.times[Math.max(state.moment, 0)] || 0) : '–');
  };
  const operationTimes = data.jumps.operations.map((o) => o.time);

  // Blocks of a step, as the vertices name them
  const tagsOf = (k) => [steps.block[k] + 1, steps.block[k] + data.stride];
  const update = (moving) => {
    const k = current(), final = atEnd();
    slider.value = Math.round(1e6 * state.time / end);
    slider.setAttribute('aria-valuetext', clockOf(state.time));
    const places = kinematics.at(valuesAt(run.joint, state.time));
    const onMachine = state.fixed === 'machine', inverse = Poses.inverse(places.work);
    const change = { place: onMachine ? places.work : Poses.none, moving, marked: final ? state.marked : tagsOf(k) };
    if (final || !stock) Object.assign(change, { parts: null, bodies: final && shown.design && bodies ? bodies.listAt(state.time, k, places, onMachine ? Poses.none : inverse, { machine: 'hidden', design: true }).slice(-1) : [] });
    else {
      state.moment = stock.momentAt(state.time);
      change.parts = stock.meshesAt(state.moment, coloring.paint);
      change.bodies = bodies.listAt(state.time, k, places, onMachine ? Poses.none : inverse, shown);
    }
    view.camera.setReach(final || shown.machine === 'hidden' ? 0 : data.reach);
    view.show(change);
    tell();
    desk.follow(final && !state.stepped ? 0 : steps.line[k], moving);
  };
  // To a time; `cursor` where a step leads there
  const go = (time, cursor) => {
    state.time = Math.min(Math.max(time, 0), end);
    state.stepped = cursor !== undefined;
    state.cursor = state.stepped ? cursor : countUpTo(steps.end, state.time);
    if (stock) update(state.playing); else ready().then(() => update(state.playing));
  };
  const step = (way) => {
    pause();
    // From within a block back to its begin, and forward to its end.
    const cursor = Math.min(Math.max(state.cursor + (way > 0 || state.stepped ? way : 0), 0), steps.count);
    go(cursor ? steps.end[cursor - 1] : 0, cursor);
  };

  // Playing
  let last = 0;
  const speed = find('speed'), halt = find('halt');
  const errors = data.jumps.findings.filter((f) => f.class === 'error').map((f) => f.time);
  const frame = (stamp) => {
    if (!state.playing) return;
    const passed = Math.min((stamp - last) / 1000, 0.5), to = state.time + passed * Number(speed.value);
    last = stamp;
    if (passed > 0) {
      const met = halt.checked ? errors[countUpTo(errors, state.time + 1e-6)] : undefined;
      if (met !== undefined && met <= to) { pause(); go(met); return; }
      if (to >= end) { pause(); go(end); return; }
      go(to);
    }
    requestAnimationFrame(frame);
  };
  function pause() {
    if (!state.playing) return;
    state.playing = false;
    play.setAttribute('aria-pressed', false);
    play.textContent = 'Play';
    update(false);
  }
  const start = async () => {
    await ready();
    if (atEnd()) go(0);
    state.playing = true;
    play.setAttribute('aria-pressed', true);
    play.textContent = 'Pause';
    last = performance.now();
    requestAnimationFrame(frame);
  };
  play.addEventListener('click', () => (state.playing ? pause() : start()));
  find('back').addEventListener('click', () => step(-1));
  find('on').addEventListener('click', () => step(1));
  slider.addEventListener('input', () => { pause(); go(end * Number(slider.value) / 1e6); });

  // Jumps: tools, operations, findings, lines
  const jump = find('jump');
  for (const [name, label] of [['tools', 'Tools'], ['operations', 'Operations'], ['findings', 'Findings']]) {
    if (!data.jumps[name].length) continue;
    const group = document.createElement('optgroup');
    group.label = label;
    for (const one of data.jumps[name]) {
      const option = document.createElement('option');
      option.value = one.time;
      option.textContent = `${clockOf(one.time).replace(/\.\d+$/, '')}  ${one.text}`;
      group.append(option);
    }
    jump.append(group);
  }
  const toTime = (time) => { pause(); go(time); };
  jump.addEventListener('change', () => { if (jump.value !== '') toTime(Number(jump.value)); jump.selectedIndex = 0; });
  const ordered = data.jumps.findings;
  const finding = (way) => {
    const times = ordered.map((f) => f.time), n = way > 0 ? countUpTo(times, state.time + 1e-6) : countUpTo(times, state.time - 1e-6) - 1;
    const one = ordered[atEnd() && way < 0 ? ordered.length - 1 : n];
    if (!one) { desk.say(way > 0 ? 'No later finding with a time.' : 'No earlier finding with a time.'); return; }
    toTime(one.time);
    view.choose(one.id);
    desk.say(`Finding at ${clockOf(one.time)}: ${one.text}`);
  };
  find('finding-back').addEventListener('click', () => finding(-1));
  find('finding-on').addEventListener('click', () => finding(1));
  // The first block of a line after the moment, or the first of all: loops come to a line many times
  const toLine = (id) => {
    let after = -1, first = -1;
    for (let k = 0; k < steps.count; k++) {
      if (steps.line[k] !== id) continue;
      if (first < 0) first = k;
      if (k >= state.cursor && after < 0) after = k;
    }
    const k = !atEnd() && after >= 0 ? after : first;
    if (k < 0) { desk.say(`${desk.words(id)} moves nothing: there is no moment of it.`); return false; }
    pause();
    go(steps.end[k], k + 1);
    return true;
  };
  const lineField = find('line');
  const lineGo = () => { const id = desk.lineNamed(Number(lineField.value)); if (id) toLine(id); else desk.say('The program has no such line.'); };
  find('line-go').addEventListener('click', lineGo);
  lineField.addEventListener('keydown', (e) => { if (e.key === 'Enter') lineGo(); });
  // At the end the surfaces that a line has cut are marked: those of the block that was clicked, or of the last run of the line
  desk.onLine((id, twice, tag) => {
    if (twice || !tag && !atEnd()) { toLine(id); return; }
    const k = tag ? run.stepOf(tag) : steps.line.lastIndexOf(id);
    state.marked = k < 0 ? [1, 0] : tagsOf(k);
    if (atEnd()) view.show({ marked: state.marked });
  });
  document.querySelectorAll('[data-moment]').forEach((link) => link.addEventListener('click', () => toTime(Number(link.dataset.moment))));

  // Ticks over the bar: tool changes, and findings above them
  const ticks = bar.querySelector('.ticks');
  const tick = (kind, one) => {
    const mark = document.createElement('i');
    mark.className = kind;
    mark.style.left = `${100 * one.time / end}%`;
    mark.title = `${clockOf(one.time)} ${one.text}`;
    ticks.append(mark);
  };
  data.jumps.tools.slice(0, 300).forEach((one) => tick('change', one));
  [...ordered].sort((a, b) => (a.class === 'error') - (b.class === 'error')).slice(-300).forEach((one) => tick(one.class, one));

  // What is shown
  const machine = find('machine'), fixed = find('fixed'), design = find('design'), fixtures = find('fixtures');
  machine.addEventListener('change', () => { shown.machine = machine.value; update(state.playing); });
  fixed.addEventListener('change', () => {
    // The eye keeps what it looks at.
    const places = kinematics.at(valuesAt(run.joint, state.time)), eye = view.camera.eye;
    const from = state.fixed === 'machine' ? Poses.inverse(places.work) : Poses.none;
    state.fixed = fixed.value;
    eye.target = Poses.point(state.fixed === 'machine' ? places.work : Poses.none, Poses.point(from, eye.target));
    update(state.playing);
  });
  design.hidden = data.design === null;
  design.addEventListener('click', async () => {
    await ready();
    shown.design = !shown.design;
    design.setAttribute('aria-pressed', shown.design);
    update(state.playing);
  });
  fixtures.hidden = !data.fixtures.length;
  fixtures.addEventListener('click', () => { shown.fixtures = !shown.fixtures; fixtures.setAttribute('aria-pressed', shown.fixtures); update(state.playing); });
  const colors = find('colors'), legend = bar.querySelector('.tag-key');
  colors.addEventListener('change', () => {
    const rows = coloring.choose(colors.value);
    if (stock) stock.shown().forEach(coloring.paint);
    legend.replaceChildren(...rows.map((row) => {
      const item = document.createElement('li'), chip = document.createElement('i');
      chip.style.background = `rgb(${row.color.join(',')})`;
      item.append(chip, row.name);
      return item;
    }));
    view.show({ tagged: Boolean(coloring.chosen()) });
    if (!coloring.chosen()) view.setColored(colors.value === 'deviation');
  });
  const diagonal = Math.sqrt(3);
  const measure = measureOf(view, desk.say, () => (atEnd() ? view.data.error : diagonal * data.cell));

  // Keys, wherever the focus is but in a field
  document.addEventListener('keydown', (e) => {
    if (e.ctrlKey || e.altKey || e.metaKey || e.target.closest('input, select, textarea, button, summary, a')) return;
    if (e.key === ' ' && e.target.closest('#part')) { if (state.playing) pause(); else start(); } else if (e.key === ',') step(-1);
    else if (e.key === '.') step(1);
    else if (e.key === '[') finding(-1);
    else if (e.key === ']') finding(1);
    else if (e.key === 'Escape') measure.set(false);
    else return;
    e.preventDefault();
  });
  bar.hidden = false;
  tell();
  document.documentElement.dataset.player = 'ready';
  Object.assign(window.proveoutPage, {
    player: {
      state: () => ({ ...state, end, line: steps.line[current()], final: atEnd() }),
      go: toTime, step, toLine, ready, measured: () => measure.result(),
      // Positions and poses at a moment, for comparison
      at: (time) => { const q = valuesAt(run.joint, time); return { q, ...kinematics.at(q) }; },
      moments: () => (stock ? [...stock.times] : []), steps: steps.count,
    },
  });
  return { go: toTime };
})();
