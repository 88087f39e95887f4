// The motion that is shown, where it can be another one: clock, picture and plots go over to it.

export class Motion {
  constructor(parts) {
    Object.assign(this, parts);
  }

  adopt(table) {
    const { source, picture, layout, plots, clock, transport, bars, tables } = this;
    const { engine, program } = table.machine;
    if (engine.resized.length) {
      const size = engine.resized.reduce((sum, each) => sum + each.size.length + 12, 0);
      const state = table.stateAt(table.first);
      const numbers = program.shapes(table.first, state, table.p, new Float64Array(size), null);
      picture.stage.reshape(engine.resized, numbers);
    }
    clock.take(table);
    source.take(table);
    for (const each of tables) each.take?.(table);
    picture.arrows.survey(table);
    bars.survey(table);
    picture.refit(table, layout);
    plots.take(table);
    transport.refit();
    transport.shown = null;
    picture.redraw();
  }

  // The numbers of the state now, if the motion is one that the page has computed.
  present() {
    const { table, time } = this.clock;
    return table.stateAt ? [...table.stateAt(time)] : null;
  }
}
