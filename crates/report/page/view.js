// The 3D view of the report: bodies and shots are in the page's JSON; nothing is fetched.
(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent);
  const place = document.getElementById('view');
  const tabs = document.getElementById('tabs');
  const caption = document.getElementById('caption');
  const choice = document.getElementById('course');
  if (!place || data.shots.length === 0) return;

  const COLOURS = [[126, 152, 190], [190, 178, 150], [214, 40, 40]].map(
    (rgb) => new THREE.Color().setRGB(...rgb.map((x) => x / 255), 'srgb'));

  // Nine i16 per triangle, little end first.
  const positions = data.bodies.map((body) => {
    const text = atob(body.data);
    const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
    const units = new DataView(bytes.buffer);
    const points = new Float32Array(body.triangles * 9);
    for (let i = 0; i < points.length; i++) points[i] = units.getInt16(2 * i, true) * body.scale;
    return points;
  });

  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  } catch (error) {
    place.textContent = 'This browser has no WebGL: the 3D view cannot be drawn.';
    document.body.dataset.view = 'no-webgl';
    return;
  }
  place.appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xf1f2f0);
  const camera = new THREE.PerspectiveCamera(40, 1, 0.05, 2000);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x999999, 2.2));
  const sun = new THREE.DirectionalLight(0xffffff, 1.6);
  sun.position.set(3, 5, 9);
  scene.add(sun);
  const stage = new THREE.Group();
  scene.add(stage);

  // A body as it lies in a shot, what is hit in red. Transparent bodies show hits inside.
  function body(shot, side) {
    const number = shot.bodies[side];
    const own = positions[number];
    const hit = new Uint8Array(own.length / 9);
    for (const triangle of shot.hits[side]) hit[triangle] = 1;
    const placed = new Float32Array(own.length);
    const r = shot.rotation, t = shot.translation;
    for (let i = 0; i < own.length; i += 3) {
      const [x, y, z] = [own[i], own[i + 1], own[i + 2]];
      for (let row = 0; row < 3; row++) {
        placed[i + row] = side === 0 ? own[i + row]
          : r[row][0] * x + r[row][1] * y + r[row][2] * z + t[row];
      }
    }
    const pick = (wanted) => {
      const count = hit.reduce((sum, is) => sum + (is === wanted ? 1 : 0), 0);
      const points = new Float32Array(count * 9);
      let at = 0;
      for (let triangle = 0; triangle < hit.length; triangle++) {
        if (hit[triangle] !== wanted) continue;
        points.set(placed.subarray(9 * triangle, 9 * triangle + 9), at);
        at += 9;
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(points, 3));
      geometry.computeVertexNormals();
      return geometry;
    };
    const skin = new THREE.Mesh(pick(0), new THREE.MeshLambertMaterial({
      color: COLOURS[side], side: THREE.DoubleSide, transparent: true, opacity: 0.55,
      depthWrite: true }));
    const damage = new THREE.Mesh(pick(1), new THREE.MeshBasicMaterial({
      color: COLOURS[2], side: THREE.DoubleSide, depthTest: false, transparent: true,
      opacity: 0.85 }));
    damage.renderOrder = 2;
    return [skin, damage];
  }

  function frame(corners) {
    const [a, b, c, d] = corners;
    const lines = new Float32Array([a, b, b, c, c, d, d, a].flat());
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(lines, 3));
    const edge = new THREE.LineSegments(geometry,
      new THREE.LineBasicMaterial({ color: 0xc89600, depthTest: false }));
    const face = new THREE.BufferGeometry();
    face.setAttribute('position',
      new THREE.BufferAttribute(new Float32Array([a, b, c, a, c, d].flat()), 3));
    const pane = new THREE.Mesh(face, new THREE.MeshBasicMaterial({ color: 0xffc800,
      side: THREE.DoubleSide, transparent: true, opacity: 0.35, depthTest: false }));
    edge.renderOrder = 4;
    pane.renderOrder = 3;
    return [pane, edge];
  }

  function lines(points, colour) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points), 3));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour }));
  }

  // A line each metre on the ground, which is where the lower body ends.
  function ground(box) {
    const points = [];
    const reach = Math.min(60, Math.max(6, 1.2 * box.getSize(new THREE.Vector3()).length()));
    const middle = box.getCenter(new THREE.Vector3());
    const [x, y] = [Math.round(middle.x), Math.round(middle.y)];
    const far = Math.ceil(reach);
    for (let k = -far; k <= far; k++) {
      // A round carpet: each line as long as the circle is wide there.
      const half = Math.sqrt(Math.max(0, far * far - k * k));
      points.push(x - half, y + k, box.min.z, x + half, y + k, box.min.z);
      points.push(x + k, y - half, box.min.z, x + k, y + half, box.min.z);
    }
    return lines(points, 0xd8dad6);
  }

  // A bar of some metres on the ground beside the bodies.
  function bar(box) {
    const most = Math.max(0.2, 0.5 * (box.max.x - box.min.x));
    const size = [10, 5, 2, 1, 0.5, 0.2].find((one) => one <= most) || 0.2;
    const middle = 0.5 * (box.min.x + box.max.x);
    const [a, b, y, z] = [middle - size / 2, middle + size / 2, box.max.y + 0.4, box.min.z + 0.01];
    const tick = 0.08;
    marks.push({ at: new THREE.Vector3(middle, y, z), text: `${size} m`, by: 8, kind: 'scale' });
    return lines([a, y, z, b, y, z, a, y - tick, z, a, y + tick, z, b, y - tick, z, b, y + tick, z],
      0x1d2126);
  }

  // Texts and the ring lie over the drawing, as large at every scale.
  const over = document.createElement('div');
  over.id = 'over';
  place.appendChild(over);
  let marks = [];
  let ring = null;
  function pixel(at) {
    const p = at.clone().project(camera);
    if (p.z > 1) return null;
    return [(p.x + 1) / 2 * place.clientWidth, (1 - p.y) / 2 * place.clientHeight];
  }

  function annotate() {
    const taken = [];
    if (ring) {
      const middle = pixel(ring.centre);
      ring.element.style.display = middle ? '' : 'none';
      if (middle) {
        const corners = ring.corners.map(pixel).filter(Boolean);
        const far = Math.max(0, ...corners.map(([x, y]) => Math.hypot(x - middle[0], y - middle[1])));
        const r = Math.min(Math.max(16, 1.25 * far), 2000);
        ring.element.style.cssText = `left:${middle[0] - r}px;top:${middle[1] - r}px;`
          + `width:${2 * r}px;height:${2 * r}px`;
        ring.mark.by = r + 4;
        // Names do not cover what touches.
        const half = 0.75 * Math.min(r, 200);
        taken.push([middle[0] - half, middle[1] - half, middle[0] + half, middle[1] + half]);
      }
    }
    for (const { at, element, by } of marks) {
      const middle = pixel(at);
      element.style.display = 'none';
      if (!middle) continue;
      element.style.display = '';
      const [w, h] = [element.offsetWidth, element.offsetHeight];
      const [x, y] = middle;
      let found = null;
      for (let ring_ = 0; ring_ < 6 && !found; ring_++) {
        const away = by + 14 * ring_;
        for (const [left, top] of [[x - w / 2, y - away - h], [x - w / 2, y + away],
          [x + away, y - h / 2], [x - away - w, y - h / 2]]) {
          const room = [left, top, left + w, top + h];
          const inside = left >= 0 && top >= 0 && room[2] <= place.clientWidth
            && room[3] <= place.clientHeight;
          const free = taken.every((one) => one[0] >= room[2] || room[0] >= one[2]
            || one[1] >= room[3] || room[1] >= one[3]);
          if (inside && free) {
            found = room;
            break;
          }
        }
      }
      if (!found) {
        element.style.display = 'none';
        continue;
      }
      taken.push(found);
      element.style.left = `${found[0]}px`;
      element.style.top = `${found[1]}px`;
    }
  }

  function mark({ at, text, by, kind }) {
    const element = document.createElement('span');
    element.className = kind;
    element.textContent = text;
    over.appendChild(element);
    return { at, element, by };
  }

  function draw() {
    renderer.render(scene, camera);
    annotate();
  }

  // All of a box is in the picture and fills it, with room for names and for the bar.
  function look(box) {
    const whole = box.clone();
    whole.max.y += 0.6;
    const corners = Array.from({ length: 8 }, (_, k) => new THREE.Vector3(
      k & 1 ? whole.max.x : whole.min.x, k & 2 ? whole.max.y : whole.min.y,
      k & 4 ? whole.max.z : whole.min.z));
    const target = whole.getCenter(new THREE.Vector3());
    const from = new THREE.Vector3(0.7, 1, 0.65).normalize();
    let away = 1.2 * Math.max(0.5, whole.getSize(new THREE.Vector3()).length());
    camera.aspect = place.clientWidth / place.clientHeight || 1;
    camera.updateProjectionMatrix();
    for (let step = 0; step < 12; step++) {
      camera.position.copy(target).addScaledVector(from, away);
      camera.lookAt(target);
      camera.updateMatrixWorld();
      const seen = corners.map((corner) => corner.clone().project(camera));
      const [left, right, low, high] = [Math.min(...seen.map((p) => p.x)),
        Math.max(...seen.map((p) => p.x)), Math.min(...seen.map((p) => p.y)),
        Math.max(...seen.map((p) => p.y))];
      // Its middle goes to that of the picture, a little lower, and its longer side fills it.
      const half = away * Math.tan(camera.fov * Math.PI / 360);
      const [right_, up] = [0, 1].map((k) =>
        new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, k));
      target.addScaledVector(right_, half * camera.aspect * (left + right) / 2);
      target.addScaledVector(up, half * ((low + high) / 2 + 0.05));
      away *= Math.max((right - left) / 1.86, (high - low) / 1.68);
    }
    controls.target.copy(target);
    camera.position.copy(target).addScaledVector(from, away);
    controls.update();
  }

  function show(number) {
    const shot = data.shots[number];
    for (const old of [...stage.children]) {
      stage.remove(old);
      old.geometry.dispose();
      old.material.dispose();
    }
    stage.add(...body(shot, 0), ...body(shot, 1));
    const box = new THREE.Box3().setFromObject(stage);
    over.replaceChildren();
    marks = [];
    ring = null;
    shot.bodies.forEach((_, side) => {
      const own = new THREE.Box3();
      for (const mesh of stage.children.slice(2 * side, 2 * side + 2)) own.expandByObject(mesh);
      if (own.isEmpty()) return;
      const at = own.getCenter(new THREE.Vector3());
      at.z = own.max.z;
      marks.push({ at, text: shot.parties[side], by: 8, kind: 'name' });
    });
    if (shot.patch) {
      const corners = shot.patch.map((corner) => new THREE.Vector3(...corner));
      const centre = corners[0].clone().add(corners[2]).multiplyScalar(0.5);
      const element = document.createElement('i');
      over.appendChild(element);
      ring = { centre, corners, element };
      marks.unshift({ at: centre, text: 'contact', by: 20, kind: 'contact-mark' });
    }
    const count = stage.children.length + (shot.patch ? 2 : 0);
    stage.add(ground(box), bar(box));
    marks = marks.map(mark);
    if (ring) [ring.mark] = marks;
    if (shot.patch) stage.add(...frame(shot.patch));
    look(box);
    // A number stays on a line with its unit.
    caption.textContent = shot.caption.replace(/(\d) (s|m)\b/g, '$1\u00a0$2');
    for (const tab of tabs.children) {
      tab.setAttribute('aria-selected', Number(tab.value) === number);
    }
    draw();
    const hits = shot.hits[0].length + shot.hits[1].length;
    document.body.dataset.view = `shot ${number}, ${count} objects, ${hits} hits`;
  }

  // The shots of a manoeuvre, the first of which is shown.
  function choose(course, asked) {
    const own = data.shots.map((_, number) => number)
      .filter((number) => data.shots[number].course === course);
    tabs.replaceChildren(...own.map((number) => {
      const tab = document.createElement('button');
      tab.type = 'button';
      tab.role = 'tab';
      tab.value = number;
      tab.textContent = data.shots[number].name;
      tab.addEventListener('click', () => show(number));
      return tab;
    }));
    place.hidden = own.length === 0;
    if (own.length === 0) {
      caption.textContent = 'This manoeuvre meets nobody, and nobody is near.';
      document.body.dataset.view = 'nothing';
      return;
    }
    show(own.includes(asked) ? asked : own[0]);
  }
  function fit() {
    const [width, height] = [place.clientWidth, place.clientHeight];
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  }
  controls.addEventListener('change', draw);
  window.addEventListener('resize', fit);
  document.addEventListener('course', (event) => {
    choose(event.detail);
    fit();
  });
  // #shot=2 opens on the second shot, those of the first manoeuvre first.
  const asked = /^#shot=(\d+)$/.exec(location.hash);
  const number = asked ? Math.min(Math.max(Number(asked[1]), 1), data.shots.length) - 1 : -1;
  const first = asked ? data.shots[number].course : choice ? Number(choice.value) : null;
  if (asked && choice) {
    choice.value = first;
    choice.dispatchEvent(new Event('input'));
  }
  choose(first, number);
  fit();
})();
