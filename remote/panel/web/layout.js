// Layered layout of a graph: back edges, layers by the longest path, order by barycentres, coordinates.

/** Distance of lines that pass a layer. */
export const THIN = 16;

/**
 * @param {string[]} names vertices, in the order of the file
 * @param {[string, string][]} edges from, to
 * @param {{ width: number, height: number, gapX: number, gapY: number }} size of a vertex and the gaps
 * @returns {{ places: Map<string, {x: number, y: number}>, routes: {from: string, to: string, back: boolean, points: {x: number, y: number}[]}[], width: number, height: number }}
 */
export function layOut(names, edges, size) {
  const back = backEdges(names, edges);
  const forward = edges.filter((_, k) => !back.has(k));
  const layer = longestPaths(names, forward);
  const { chains, links } = splitLongEdges(edges, back, layer);
  const layers = orderLayers(layer, links);
  const places = coordinates(layers, links, size);
  const routes = edges.map(([from, to], k) => ({ from, to, back: back.has(k), points: chains[k].map((vertex) => places.get(vertex)) }));
  const ys = [...places.values()].map(({ y }) => y);
  return { places, routes, width: Math.max(1, layers.length) * (size.width + size.gapX) - size.gapX, height: Math.max(0, ...ys) + size.height };
}

/** Indices of the edges that lead back to a vertex on the current path of a depth-first search. */
function backEdges(names, edges) {
  const out = new Map(names.map((name) => [name, []]));
  edges.forEach(([from, to], k) => out.get(from).push([to, k]));
  const state = new Map(), back = new Set();
  const visit = (name) => {
    state.set(name, "open");
    for (const [to, k] of out.get(name)) {
      if (state.get(to) === "open") back.add(k);
      else if (!state.has(to)) visit(to);
    }
    state.set(name, "done");
  };
  const entered = new Set(edges.map(([, to]) => to));
  for (const name of [...names.filter((n) => !entered.has(n)), ...names]) if (!state.has(name)) visit(name);
  return back;
}

function longestPaths(names, edges) {
  const before = new Map(names.map((name) => [name, []]));
  for (const [from, to] of edges) before.get(to).push(from);
  const layer = new Map();
  const find = (name) => {
    if (!layer.has(name)) layer.set(name, Math.max(0, ...before.get(name).map((from) => find(from) + 1)));
    return layer.get(name);
  };
  names.forEach(find);
  return layer;
}

/** Adds a vertex in each layer that the forward edges of one source pass: they share it, and every link joins neighbouring layers. */
function splitLongEdges(edges, back, layer) {
  const links = new Map();
  const chains = edges.map(([from, to], k) => {
    if (back.has(k)) return [from, to];
    const chain = [from];
    for (let l = layer.get(from) + 1; l < layer.get(to); ++l) {
      const vertex = `\n${from}\n${l}`;   // no name has a line break
      layer.set(vertex, l);
      chain.push(vertex);
    }
    chain.push(to);
    for (let i = 1; i < chain.length; ++i) links.set(`${chain[i - 1]}\t${chain[i]}`, [chain[i - 1], chain[i]]);
    return chain;
  });
  return { chains, links: [...links.values()] };
}

function neighbours(links, side) {
  const map = new Map();
  for (const link of links) map.set(link[side], [...(map.get(link[side]) ?? []), link[1 - side]]);
  return map;
}

function orderLayers(layer, links) {
  const layers = [];
  for (const [name, l] of layer) (layers[l] ??= []).push(name);
  const sides = [neighbours(links, 1), neighbours(links, 0)];
  const rank = new Map();
  const renumber = (vertices) => vertices.forEach((name, k) => rank.set(name, k));
  layers.forEach(renumber);
  for (let pass = 0; pass < 12; ++pass) {
    const near = sides[pass % 2];
    for (const vertices of pass % 2 ? layers.toReversed() : layers) {
      const centre = new Map(vertices.map((name) => [name, mean((near.get(name) ?? []).map((other) => rank.get(other)), rank.get(name))]));
      vertices.sort((a, b) => centre.get(a) - centre.get(b));
      renumber(vertices);
    }
  }
  return layers;
}

const mean = (values, otherwise) => (values.length ? values.reduce((a, b) => a + b, 0) / values.length : otherwise);

/** Moves each vertex towards the mean of its neighbours; the order and the distances within a layer stay. */
function coordinates(layers, links, { width, height, gapX, gapY }) {
  const [left, right] = [neighbours(links, 1), neighbours(links, 0)];
  const places = new Map();
  const room = (name) => (name.startsWith("\n") ? THIN : height + gapY);
  layers.forEach((vertices, l) => {
    let y = 0;
    for (const name of vertices) { places.set(name, { x: l * (width + gapX), y }); y += room(name); }
  });
  for (let pass = 0; pass < 16; ++pass) {
    for (const vertices of pass % 2 ? layers.toReversed() : layers) {
      const wanted = vertices.map((name) => mean([...(left.get(name) ?? []), ...(right.get(name) ?? [])].map((other) => places.get(other).y), places.get(name).y));
      spread(vertices, wanted, places, room);
    }
  }
  const lowest = Math.min(0, ...[...places.values()].map(({ y }) => y));
  for (const place of places.values()) place.y -= lowest;
  return places;
}

/** Wanted places with the least distances: pushed down from the top, and up from the bottom; the mean of both. */
function spread(vertices, wanted, places, room) {
  const down = [], up = [];
  vertices.forEach((name, k) => { down[k] = k ? Math.max(wanted[k], down[k - 1] + room(vertices[k - 1])) : wanted[k]; });
  for (let k = vertices.length - 1; k >= 0; --k) up[k] = k < vertices.length - 1 ? Math.min(wanted[k], up[k + 1] - room(vertices[k])) : wanted[k];
  vertices.forEach((name, k) => { places.get(name).y = (down[k] + up[k]) / 2; });
}
