// The 3D view of the report: bodies and shots are in the page's JSON; nothing is fetched.
(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent);
  const place = document.getElementById('view');
  const tabs = document.getElementById('tabs');
  const caption = document.getElementById('caption');
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

  function draw() {
    renderer.render(scene, camera);
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
    const middle = box.getCenter(new THREE.Vector3());
    const reach = box.getSize(new THREE.Vector3()).length() / 2;
    if (shot.patch) stage.add(...frame(shot.patch));
    const from = new THREE.Vector3(0.7, 1, 0.65).normalize().multiplyScalar(reach * 2.4);
    camera.position.copy(middle).add(from);
    controls.target.copy(middle);
    controls.update();
    caption.textContent = shot.caption;
    [...tabs.children].forEach((tab, at) => tab.setAttribute('aria-selected', at === number));
    draw();
    const hits = shot.hits[0].length + shot.hits[1].length;
    document.body.dataset.view = `shot ${number}, ${stage.children.length} objects, ${hits} hits`;
  }

  data.shots.forEach((shot, number) => {
    const tab = document.createElement('button');
    tab.type = 'button';
    tab.role = 'tab';
    tab.textContent = `${number + 1} ${shot.name}`;
    tab.addEventListener('click', () => show(number));
    tabs.appendChild(tab);
  });
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
  // #shot=2 opens on the second candidate.
  const asked = /^#shot=(\d+)$/.exec(location.hash);
  const first = data.shots.findIndex((shot) => shot.patch);
  show(asked ? Math.min(Number(asked[1]), data.shots.length) - 1 : Math.max(first, 0));
  fit();
})();
