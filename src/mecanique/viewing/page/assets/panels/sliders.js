// Sliders for parameters and initial values of a live view.

export function round(value) {
  return String(Number(Number(value).toPrecision(6)));
}

// Sets the sliders to what other pages, or this one before it was loaded anew, have chosen.
export function setSliders(values) {
  for (const [kind, name, value] of values)
    for (const slider of document.querySelectorAll(`input[data-kind=${kind}]`))
      if (slider.dataset.name === name && slider !== document.activeElement) {
        slider.value = value;
        slider.closest("tr").querySelector("output").textContent = round(value);
      }
}

// Sliders for parameters and initial values; the motion starts again with what they are set to.
export function wireSliders(clock) {
  for (const slider of document.querySelectorAll("input[data-name]")) {
    slider.disabled = false;
    slider.oninput = () => {
      slider.closest("tr").querySelector("output").textContent = round(slider.value);
    };
    slider.onchange = () =>
      clock.send({
        do: slider.dataset.kind,
        name: slider.dataset.name,
        value: Number(slider.value),
      });
  }
}
