// What the report page uses of three.js; see README.md for how three.min.js is made from it.
export { BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group,
  HemisphereLight, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial,
  PerspectiveCamera, Scene, SphereGeometry, GridHelper, ArrowHelper, Vector3, WebGLRenderer, Box3
} from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
