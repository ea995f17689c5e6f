// What report.html uses of three.js and uPlot; esbuild leaves the rest out.
export {
  BufferAttribute, BufferGeometry, Color, DataArrayTexture, DataTexture, DoubleSide, FloatType, GLSL3, Group,
  LineSegments, Mesh, PerspectiveCamera, Points, Quaternion, RedFormat, RedIntegerFormat, RGBAIntegerFormat,
  Scene, ShaderMaterial, ShortType, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { default as uPlot } from "uplot";
