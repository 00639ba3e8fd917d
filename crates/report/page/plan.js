// The plan view: moves bodies along the tracks in the page's JSON. It decides nothing.
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

  const show = () => {
    const k = Number(choice.value);
    const time = Number(slider.value);
    const course = scene.courses[k];
    for (const group of plan.querySelectorAll('[data-course]')) {
      group.style.display = Number(group.dataset.course) === k ? '' : 'none';
    }
    scene.parties.forEach((party, number) => {
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
      const name = body.querySelector('text');
      if (name) name.setAttribute('transform', `translate(${e} ${f})`);
      const shape = body.querySelector('.body');
      shape.classList.toggle('met', !isEgo && contact !== undefined);
      shape.classList.toggle('struck', heavy !== undefined && time > heavy.time_s);
    });
    const open = course.open_from_s !== null && time > course.open_from_s;
    const text = `${time.toFixed(2)} s${open ? ': not known' : ''}`;
    shown.textContent = text;
    slider.setAttribute('aria-valuetext', text);
  };

  controls.hidden = false;
  choice.addEventListener('input', show);
  slider.addEventListener('input', show);
  show();
})();
