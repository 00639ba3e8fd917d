// The plan view: moves bodies along the tracks in the page's JSON, and lays out their names. It
// decides nothing.
(() => {
  'use strict';
  const { scene, view } = JSON.parse(document.getElementById('data').textContent);
  const plan = document.getElementById('plan');
  const controls = document.getElementById('controls');
  const choice = document.getElementById('course');
  const slider = document.getElementById('time');
  const shown = document.getElementById('now');
  if (!plan || !controls) return;

  // [time, x, y, cos, sin]: linear between samples, still before the first and after the last.
  const at = (track, time) => {
    let low = 0;
    let high = track.length - 1;
    if (time >= track[high][0]) return track[high];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (track[middle][0] <= time) low = middle; else high = middle;
    }
    const [a, b] = [track[low], track[high]];
    const share = b[0] > a[0] ? Math.max(0, (time - a[0]) / (b[0] - a[0])) : 0;
    const pose = a.map((value, k) => value + (b[k] - value) * share);
    const length = Math.hypot(pose[3], pose[4]) || 1;
    return [time, pose[1], pose[2], pose[3] / length, pose[4] / length];
  };

  // A line of a member, [time, x, y], at a time.
  const point = (line, time) => {
    let k = line.length - 1;
    if (time >= line[k][0]) return line[k];
    while (k > 1 && line[k - 1][0] > time) k--;
    const [a, b] = [line[k - 1], line[k]];
    const share = b[0] > a[0] ? Math.max(0, (time - a[0]) / (b[0] - a[0])) : 0;
    return a.map((value, i) => value + (b[i] - value) * share);
  };
  const place = ([, x, y]) => [(x - view.left_m) * view.per_m, (view.top_m - y) * view.per_m];

  // A dot for each body in each member, where it is at the time.
  const ghosts = [];
  for (const member of scene.members) {
    scene.parties.forEach((party, number) => {
      const dot = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
      dot.setAttribute('class', number === scene.ego ? 'ghost own' : 'ghost');
      dot.setAttribute('r', '2.2');
      plan.querySelector('[data-body]').before(dot);
      ghosts.push({ dot, number, member });
    });
  }
  const haunt = (k, time) => {
    for (const { dot, number, member } of ghosts) {
      const course = member.courses[k];
      const reaction = course.reactions.find(([who]) => who === number);
      const line = number === scene.ego ? course.ego
        : reaction ? reaction[1] : member.parties[number];
      if (line.length === 0) continue;
      const [x, y] = place(point(line, time));
      dot.setAttribute('cx', x.toFixed(1));
      dot.setAttribute('cy', y.toFixed(1));
    }
  };

  // Names lie beside their bodies and cover neither other texts, nor contacts, nor other bodies; a
  // name without room is not shown.
  const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width
    && a.y < b.y + b.height && b.y < a.y + a.height;
  const layout = (course, poses) => {
    const [, , width, height] = plan.getAttribute('viewBox').split(' ').map(Number);
    const taken = [];
    const shown = '[data-course]:not([style*="none"])';
    for (const mark of plan.querySelectorAll(
      `${shown} text, ${shown} .hit, ${shown} .gap, ${shown} .dot.own, :scope > text, :scope > .scale`)) {
      const box = mark.getBBox();
      // Room between a name and another text, and the line that leads to that.
      const by = mark.localName === 'text' ? 8 : 0;
      taken.push({ x: box.x - by, y: box.y, width: box.width + 2 * by, height: box.height });
    }
    for (const sample of course.ego) {
      const [x, y] = place(sample);
      taken.push({ x: x - 4, y: y - 4, width: 8, height: 8 });
    }
    const reach = scene.parties.map((party) => view.per_m
      * Math.min(...[0, 1].map((k) => Math.max(...party.outline_m.map((p) => Math.abs(p[k]))))));
    const bodies = poses.flatMap(([x, y, cos, sin], number) => {
      const party = scene.parties[number];
      const long = view.per_m * Math.max(...party.outline_m.map((p) => Math.abs(p[0])));
      const r = Math.max(4, 0.9 * reach[number]);
      const count = Math.min(12, Math.max(1, Math.round(long / r)));
      return Array.from({ length: count + 1 }, (_, k) => {
        const along = (2 * k / count - 1) * Math.max(0, long - r);
        return { x: x + cos * along - r, y: y - sin * along - r, width: 2 * r, height: 2 * r };
      });
    });
    taken.push(...bodies);
    const isMet = (number) => course.contacts.some((one) => one.party === number);
    const order = scene.parties.map((_, number) => number).sort((a, b) =>
      (b === scene.ego) - (a === scene.ego) || isMet(b) - isMet(a) || a - b);
    for (const number of order) {
      const text = plan.querySelector(`[data-body="${number}"] > text`);
      if (!text) continue;
      text.style.display = '';
      text.removeAttribute('transform');
      text.setAttribute('x', '0');
      text.setAttribute('y', '0');
      const size = text.getBBox();
      const [x, y] = poses[number];
      let found = null;
      for (let ring = 0; ring < 7 && !found; ring++) {
        const by = reach[number] + 6 + 14 * ring;
        for (const [left, top] of [
          [x - size.width / 2, y - by - size.height], [x - size.width / 2, y + by],
          [x + by, y - by - size.height / 2], [x - by - size.width, y - by - size.height / 2],
          [x + by, y + by - size.height / 2], [x - by - size.width, y + by - size.height / 2],
        ]) {
          const room = { x: left - 2, y: top, width: size.width + 4, height: size.height };
          const inside = room.x >= 0 && room.y >= 0 && room.x + room.width <= width
            && room.y + room.height <= height;
          if (inside && !taken.some((one) => overlap(one, room))) {
            found = room;
            break;
          }
        }
      }
      if (!found) {
        text.style.display = 'none';
        continue;
      }
      taken.push(found);
      text.setAttribute('x', (found.x + 2 - size.x).toFixed(1));
      text.setAttribute('y', (found.y - size.y).toFixed(1));
    }
  };

  const show = () => {
    const k = Number(choice.value);
    const time = Number(slider.value);
    const course = scene.courses[k];
    for (const group of plan.querySelectorAll('[data-course]')) {
      group.style.display = Number(group.dataset.course) === k ? '' : 'none';
    }
    for (const group of plan.querySelectorAll('[data-spread]')) {
      const reacts = course.reactions.some(([who]) => who === Number(group.dataset.spread));
      group.style.display = reacts ? 'none' : '';
    }
    haunt(k, time);
    const poses = scene.parties.map((party, number) => {
      const body = plan.querySelector(`[data-body="${number}"]`);
      const contact = course.contacts.find((one) => one.party === number);
      const heavy = course.contacts.find((one) => one.party === number && one.is_heavy);
      const reaction = course.reactions.find(([who]) => who === number);
      const isEgo = number === scene.ego;
      const track = isEgo ? course.ego : reaction ? reaction[1] : party.paths[party.followed].track;
      const [, x, y, cos, sin] = at(track, heavy ? Math.min(time, heavy.time_s) : time);
      const [e, f] = [(x - view.left_m) * view.per_m, (view.top_m - y) * view.per_m];
      body.querySelector('.turned').setAttribute('transform',
        `matrix(${cos} ${-sin} ${sin} ${cos} ${e} ${f})`);
      const shape = body.querySelector('.body');
      shape.classList.toggle('met', !isEgo && contact !== undefined);
      shape.classList.toggle('struck', heavy !== undefined && time > heavy.time_s);
      return [e, f, cos, sin];
    });
    layout(course, poses);
    const open = course.open_from_s !== null && time > course.open_from_s;
    const text = `${time.toFixed(2)} s${open ? ': not known' : ''}`;
    shown.textContent = text;
    slider.setAttribute('aria-valuetext', text);
  };

  controls.hidden = false;
  choice.addEventListener('input', () => {
    show();
    // What touches in 3D follows.
    document.dispatchEvent(new CustomEvent('course', { detail: Number(choice.value) }));
  });
  window.addEventListener('resize', show);
  slider.addEventListener('input', show);
  show();
})();
