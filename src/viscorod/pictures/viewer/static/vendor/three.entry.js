// What the view in space takes from three.js; README.md tells how three.min.js is made of it.
export {
  AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight,
  DoubleSide, GridHelper, Group, Line, LineBasicMaterial, LineDashedMaterial, Mesh, MeshLambertMaterial,
  OctahedronGeometry, PerspectiveCamera, Quaternion, SRGBColorSpace, Scene, ShapeUtils, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
