// Vectors as plain arrays.

export const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

export const add = (a, b) => a.map((x, i) => x + b[i]);

export const subtract = (a, b) => a.map((x, i) => x - b[i]);

export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export const unit = (a) => a.map((x) => x / Math.hypot(...a));
