/* The page of error against time of shadows in fog. data: {files: [{path, bench: docs/volumes.schema.json}]}
 *
 * A plot for each scene: a line is a technique, a point a setting of its knob; the front is what nothing as near is faster than. A colour with
 * a mark is a technique, in all plots; rivals are dashed.
 * SPDX-License-Identifier: GPL-3.0-or-later */

const scenes = data.files.flatMap(({ path, bench }) => bench.scenes.map((scene) =>
    ({ ...scene, machine: bench.machine, label: clean(data.files.length > 1 ? `${scene.name}, ${base_name(path)}` : scene.name) })));
const techniques = [...new Map(scenes.flatMap((s) => s.techniques).map((t) => [t.name, t])).values()]
    .filter((t) => scenes.some((s) => s.cells.some((c) => c.technique === t.name)));

/* figures --------------------------------------------------------------------------------------------------------------------- */

/* Two digits that count, down to 5e-7. */
const error_text = (value) => value === null ? "–" : value && Math.abs(value) < 1e-3 ? value.toExponential(1).replace(".0e", "e")
    : significant(value, 2);
const ERROR = { tick: (value) => value < 1e-3 ? value.toExponential(0) : String(+value.toPrecision(1)) };
const milliseconds = (value) => seconds(value * 1e-3);
const setting_of = (cell) => cell.knob === "-" ? "" : `${cell.value} ${clean(cell.knob)}`;
const cell_name = (cell) => [clean(cell.technique), setting_of(cell)].filter(Boolean).join(", ");
const behind_text = (cell) => cell.front ? "on the front" : `${significant(cell.behind)} times as long as what is as near`;
const drawn_cells = (scene) => scene.cells.filter((c) => !c.refused);

/* Logarithmic axes have no place for 0. */
const is_shown = (cell) => cell.ms.median > 0 && cell.error.relative_rms > 0;

/* plots ----------------------------------------------------------------------------------------------------------------------- */

const colour_of = (n) => COLOURS[n % COLOURS.length];
const mark_of = (n) => MARKS[Math.floor(n / COLOURS.length) % MARKS.length];
const time_of = ({ ms }) => ({ median: ms.median / 1e3, min: ms.least / 1e3, max: ms.greatest / 1e3 });
const points_of = (cells) => cells.filter(is_shown).map((cell) => ({ cell, x: time_of(cell), y: exactly(cell.error.relative_rms) }));
const at_medians = (points) => points.map((p) => ({ ...p, x: p.x.median, y: p.y.median }));

function line_of(technique, n, scene) {
    const points = points_of(drawn_cells(scene).filter((c) => c.technique === technique.name));
    return { data: at_medians(points), spreads: points, colour: colour_of(n), borderColor: colour_of(n), backgroundColor: colour_of(n),
        pointStyle: mark_of(n)[0], borderDash: technique.rival ? [6, 4] : [], borderWidth: 1.5, pointRadius: 4, pointHoverRadius: 6 };
}

/* In steps: until the next setting is reached, nothing nearer is to be had. */
function front_line(scene) {
    const points = points_of(drawn_cells(scene).filter((c) => c.front)).sort((a, b) => a.x.median - b.x.median);
    return { data: at_medians(points).map(({ x, y }) => ({ x, y })), stepped: "before", borderColor: "#8d8a80", borderWidth: 5, pointRadius: 0,
        pointHitRadius: 0, order: 1 };
}

function scene_figure(scene, n) {
    const cells = drawn_cells(scene), points = points_of(cells), front = cells.filter((c) => c.front).length;
    const keys = techniques.map((t, k) => [el("b", { style: `color: ${colour_of(k)}` }, mark_of(k)[1]), clean(t.name)]);
    if (!points.length) return [];
    return [figure({ name: `front-${n + 1}`, height: 380, keys: [...keys, [swatch("#8d8a80"), "the front"]],
        title: `${scene.label}: ${front} of ${plural(cells.length, "setting")} on the front`,
        caption: `Against ${clean(scene.reference)}.` },
    () => line_chart([front_line(scene), ...techniques.map((t, k) => line_of(t, k, scene))],
        log_axis("time of a frame", SECONDS, values_of(points, "x")), log_axis("relative RMS error", ERROR, values_of(points, "y")),
        ({ cell }) => `${cell_name(cell)}: ${milliseconds(cell.ms.median)}, ${error_text(cell.error.relative_rms)}; ${behind_text(cell)}`))];
}

/* text ------------------------------------------------------------------------------------------------------------------------ */

function show_head() {
    document.title = "vxs: fog measured";
    show(el("h1", {}, `Shadows in fog: error against time of ${plural(techniques.length, "technique")} in ${plural(scenes.length, "scene")}`));
    for (const { path, bench } of data.files) {
        const m = bench.machine, s = bench.scenes[0];
        show(soft(clean((data.files.length > 1 ? `${base_name(path)}: ` : "")
            + `${s.generator} on ${plural(m.cores, "core")} of ${m.processor}, ${significant(m.memory_bytes / 2 ** 30)} GiB, ${m.system}, OpenGL by `
            + `${s.renderer}; ${s.width_px} x ${s.height_px} pixels, medians of ${plural(s.rounds, "round")}, in each of which every setting is drawn once.`)));
    }
    show(el("p", {}, "A setting is on the front when nothing that is as near to the reference is faster. Of the others it is told how many times as "
        + "long they take as the quickest that is as near."),
        soft("Both axes are logarithmic; lower and further left is better. A line is a technique, its points are settings of its knob; rivals are "
        + "dashed. Bars reach from the least to the greatest round."));
}

/* How often each technique is on the front, and how near to it its best settings come where it is not. */
function show_techniques() {
    const row = (t) => {
        const of_scenes = scenes.map((s) => drawn_cells(s).filter((c) => c.technique === t.name)).filter((cells) => cells.length);
        const fronts = of_scenes.filter((cells) => cells.some((c) => c.front)).length;
        const least = of_scenes.map((cells) => Math.min(...cells.map((c) => c.behind)));
        const errors = of_scenes.flat().map((c) => c.error.relative_rms).filter((e) => e !== null);
        return [text(clean(t.name), t.rival ? [" ", el("small", {}, "rival")] : ""), text(clean(t.knob)), `${fronts} of ${of_scenes.length}`,
            least.length ? range_text(least, (value) => significant(value)) : "", errors.length ? range_text(errors, error_text) : "", long(clean(t.limit))];
    };
    show(el("h2", {}, "The techniques"), table(["technique", "knob", "scenes with it on the front", "its least behind", "RMS error",
        "what it comes to as its knob grows"], techniques.map(row)));
}

function cell_row(cell, has_lamp) {
    const name = [text(clean(cell.technique)), text(setting_of(cell))], e = cell.error, strong = (figure) => cell.front ? el("b", {}, figure) : figure;
    if (cell.refused) return [...name, "refused", ...Array(has_lamp ? 8 : 7).fill("")];
    const lamp = has_lamp ? [cell.epipole ? error_text(cell.epipole.relative_rms) : ""] : [];
    return [...name, [strong(milliseconds(cell.ms.median)), el("small", {}, ` ${milliseconds(cell.ms.least)}–${milliseconds(cell.ms.greatest)}`)],
        strong(error_text(e.relative_rms)), strong(cell.front ? "front" : significant(cell.behind)), error_text(e.signed_mean),
        error_text(e.percentile_99), error_text(e.most), ...lamp, error_text(cell.flicker), milliseconds(cell.open_ms)];
}

function show_scene(scene) {
    const has_lamp = scene.cells.some((c) => c.epipole);
    show(el("h3", {}, `${scene.label}: ${clean(scene.light)}, ${bytes(scene.file_bytes)}`),
        table(["technique", "knob", "a frame", "RMS", "behind", "mean", "99 %", "largest", ...(has_lamp ? ["RMS at the lamp"] : []), "flicker",
            "first frame"], scene.cells.map((c) => cell_row(c, has_lamp))));
}

function show_figures() {
    show(el("h2", {}, "The figures"), soft("Times are medians of rounds, and least to greatest; a first frame has with it what it is made ready by. Errors "
        + "are of linear airlight; mean, 99 % and largest are relative to the brightest pixel. Flicker is how much the error changes while the camera moves "
        + "by a third of a texel. At a lamp that is seen are the pixels whose rays pass it within four of its radii."));
    scenes.forEach(show_scene);
}

show_head();
show(el("div", { class: "plots" }, ...scenes.flatMap(scene_figure)));
show_techniques();
show_figures();
draw_all(false);
