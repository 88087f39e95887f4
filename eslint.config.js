import js from "@eslint/js";
import globals from "globals";

const PAGE = "src/mecanique/{viewing/page,teaching}/assets/**/*.js";

export default [
  { ignores: ["**/*.min.js", ".venv/", "build/", "dist/", "docs/_generated/"] },
  js.configs.recommended,
  {
    rules: {
      complexity: ["error", 12],
      eqeqeq: "error",
      "max-depth": ["error", 4],
      "max-lines-per-function": ["error", 75],
      "max-params": ["error", 5],
      "no-else-return": "error",
      "no-shadow": "error",
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
    },
  },
  {
    files: [PAGE],
    languageOptions: { globals: { ...globals.browser, MeshCat: "readonly" } },
    rules: { "no-implied-eval": "error", "no-eval": "error", "no-script-url": "error" },
  },
  { files: ["docs/try/*.js"], languageOptions: { globals: globals.browser } },
  { files: ["tests/**/*.js"], languageOptions: { globals: globals.node } },
];
