// Some colours of viridis (matplotlib, CC0). Its lightness is uniform, so it can be read in grey
// and by the colour-blind.
export const STOPS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

// `share` in [0, 1] -> [r, g, b], each 0 to 255.
export function viridis(share) {
  const place = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1), i = Math.min(Math.floor(place), STOPS.length - 2), part = place - i;
  return STOPS[i].map((low, channel) => low + part * (STOPS[i + 1][channel] - low));
}
// Converts a part of an sRGB colour to linear light, as renderers use it, from 0 to 1.
const toLinear = (part) => (part <= 10 ? part / 3294.6 : ((part / 255 + 0.055) / 1.055) ** 2.4);
const LIGHT = Array.from({ length: 256 }, (_, i) => viridis(i / 255).map(toLinear));
export const viridisLight = (share) => LIGHT[Math.round(255 * Math.min(Math.max(share, 0), 1))];

// The colours as a CSS gradient whose values grow to the `top` or to the `right`.
export const viridisBar = (side = 'top') => `linear-gradient(to ${side}, ${STOPS.map((stop) => `rgb(${stop})`).join(', ')})`;

// Returns the next larger value of 1, 2, 3, 4, 5, 6, 8 times a power of ten.
export function niceAbove(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 2, 3, 4, 5, 6, 8, 10].find((step) => step * power >= value * (1 - 1e-9));
}

// The value at full colour of each quantity. It is a round number that only grows, so that colours
// can be compared over time. All views of an object share one scale.
export class ColourScale {
  constructor() {
    this.begin();
  }
  begin() {
    this.full = { moved: 0, traction: 0 };
  }
  // `largest`: present value; `least`: smallest value at full colour.
  raise(quantity, largest, least) {
    this.full[quantity] = Math.max(this.full[quantity], niceAbove(Math.max(largest || 0, least)));
  }
}
