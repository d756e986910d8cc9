// Whether the processor draws, as on a machine without a graphics processor.

export const drawnBySoftware = (() => {
  const context = document.createElement("canvas").getContext("webgl2");
  const known = context && context.getExtension("WEBGL_debug_renderer_info");
  const name = known ? context.getParameter(known.UNMASKED_RENDERER_WEBGL) : "";
  if (context) context.getExtension("WEBGL_lose_context").loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
})();
