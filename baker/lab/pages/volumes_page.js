/* The page of error against time of shadows in fog, of smoke, and of area lights. data: {files: [{path, bench: docs/volumes.schema.json}]}
 *
 * A plot for each scene: a line is a technique, a point a setting of its knob; the front joins the points for which no other point is
 * both faster and at least as exact. Smoke has a second plot, against bytes. A technique has the same colour and mark in all plots;
 * rivals are dashed.
 * SPDX-License-Identifier: GPL-3.0-or-later */

const scenes = data.files.flatMap(({ path, bench }) => bench.scenes.map((scene) =>
    ({ ...scene, machine: bench.machine, label: clean(data.files.length > 1 ? `${scene.name}, ${base_name(path)}` : scene.name) })));
const techniques = [...new Map(scenes.flatMap((s) => s.techniques).map((t) => [t.name, t])).values()]
    .filter((t) => scenes.some((s) => s.cells.some((c) => c.technique === t.name)));

/* figures ---------------------------------------------------------------------------------------------------------------------- */

/* Two significant digits, down to 5e-7. */
const error_text = (value) => value === null ? "–" : value && Math.abs(value) < 1e-3 ? value.toExponential(1).replace(".0e", "e")
    : significant(value, 2);
const ERROR = { tick: (value) => value < 1e-3 ? value.toExponential(0) : String(+value.toPrecision(1)) };
const milliseconds = (value) => seconds(value * 1e-3);
const setting_of = (cell) => cell.knob === "-" ? "" : `${cell.value} ${clean(cell.knob)}`;
const cell_name = (cell) => [clean(cell.technique), setting_of(cell)].filter(Boolean).join(", ");
const behind_text = (cell) => cell.front ? "on the front" : `${significant(cell.behind)} times as long as what is as near`;
const drawn_cells = (scene) => scene.cells.filter((c) => !c.refused);

/* The horizontal axis of a plot: `of` is its value of a cell. Logarithmic axes cannot show 0. */
const TIME = { suffix: "", label: ({ clock }) => clock === "processor" ? "processor time of a frame" : "time of a frame", unit: SECONDS,
    of: ({ ms }) => ({ median: ms.median / 1e3, min: ms.least / 1e3, max: ms.greatest / 1e3 }) };
const TEXEL_BYTES = { suffix: "-bytes", label: () => "bytes a texel", unit: { tick: bytes, binary: true }, of: (cell) => exactly(cell.bytes_per_texel) };

/* plots ------------------------------------------------------------------------------------------------------------------------ */

const colour_of = (n) => COLOURS[n % COLOURS.length];
const mark_of = (n) => MARKS[Math.floor(n / COLOURS.length) % MARKS.length];
const points_of = (cells, axis) => cells.map((cell) => ({ cell, x: axis.of(cell), y: exactly(cell.error.relative_rms) }))
    .filter((p) => p.x.median > 0 && p.y.median > 0);
const at_medians = (points) => points.map((p) => ({ ...p, x: p.x.median, y: p.y.median }));
const cells_of = (scene, technique) => drawn_cells(scene).filter((c) => c.technique === technique.name);

function line_of(technique, n, scene, axis) {
    const points = points_of(cells_of(scene, technique), axis);
    return { data: at_medians(points), spreads: points, colour: colour_of(n), borderColor: colour_of(n), backgroundColor: colour_of(n),
        pointStyle: mark_of(n)[0], borderDash: technique.rival ? [6, 4] : [], borderWidth: 1.5, pointRadius: 4, pointHoverRadius: 6 };
}

/* In steps: between two settings the error is that of the faster one. */
function front_line(scene) {
    const points = points_of(drawn_cells(scene).filter((c) => c.front), TIME).sort((a, b) => a.x.median - b.x.median);
    return { data: at_medians(points).map(({ x, y }) => ({ x, y })), stepped: "before", borderColor: "#8d8a80", borderWidth: 5, pointRadius: 0,
        pointHitRadius: 0, order: 1 };
}

/* fronts: lines below those of the techniques;   told: the end of the title, after the scene's name */
function error_figure(scene, n, axis, fronts, told) {
    const cells = drawn_cells(scene), points = points_of(cells, axis);
    const own = techniques.map((t, k) => ({ t, k })).filter(({ t }) => cells_of(scene, t).length);
    const keys = own.map(({ t, k }) => [el("b", { style: `color: ${colour_of(k)}` }, mark_of(k)[1]), clean(t.name)]);
    if (!points.length) return [];
    return [figure({ name: `front-${n + 1}${axis.suffix}`, height: 380, keys: fronts.length ? [...keys, [swatch("#8d8a80"), "the front"]] : keys,
        title: `${scene.label}: ${told}`, caption: `Against ${clean(scene.reference)}.` },
    () => line_chart([...fronts, ...own.map(({ t, k }) => line_of(t, k, scene, axis))],
        log_axis(axis.label(scene), axis.unit, values_of(points, "x")), log_axis("relative RMS error", ERROR, values_of(points, "y")),
        ({ cell }) => `${cell_name(cell)}: ${[milliseconds(cell.ms.median), ...bytes_told(cell), error_text(cell.error.relative_rms)].join(", ")}; ${behind_text(cell)}`))];
}

const bytes_told = (cell) => cell.bytes_per_texel ? [`${significant(cell.bytes_per_texel)} B a texel`] : [];
const has_bytes = (scene) => drawn_cells(scene).some((c) => c.bytes_per_texel);

function scene_figures(scene, n) {
    const cells = drawn_cells(scene), front = cells.filter((c) => c.front).length;
    return [...error_figure(scene, n, TIME, [front_line(scene)], `${front} of ${plural(cells.length, "setting")} on the front`),
        ...(has_bytes(scene) ? error_figure(scene, n, TEXEL_BYTES, [], "error against bytes") : [])];
}

/* text ------------------------------------------------------------------------------------------------------------------------- */

const sizes_of = (bench) => [...new Set(bench.scenes.map((s) => `${s.width_px} x ${s.height_px}`))].join(" or ");

function show_head() {
    document.title = "vxs: fog measured";
    show(el("h1", {}, `Shadows in fog and smoke: error against time of ${plural(techniques.length, "technique")} in ${plural(scenes.length, "scene")}`));
    for (const { path, bench } of data.files) {
        const m = bench.machine, s = bench.scenes[0];
        show(soft(clean((data.files.length > 1 ? `${base_name(path)}: ` : "")
            + `${s.generator} on ${plural(m.cores, "core")} of ${m.processor}, ${significant(m.memory_bytes / 2 ** 30)} GiB, ${m.system}, OpenGL by `
            + `${s.renderer}; ${sizes_of(bench)} pixels, medians of ${plural(s.rounds, "round")}, in each of which every setting is drawn once.`)));
    }
    show(el("p", {}, "A setting is on the front when nothing that is as near to the reference is faster. Of the others it is told how many times as "
        + "long they take as the quickest that is as near."),
        soft("Both axes are logarithmic; lower and further left is better. A line is a technique, its points are settings of its knob; rivals are "
        + "dashed. Bars reach from the least to the greatest round."));
}

/* How often each technique is on the front; elsewhere, the distance of its best settings from the front. */
function show_techniques() {
    const row = (t) => {
        const of_scenes = scenes.map((s) => cells_of(s, t)).filter((cells) => cells.length);
        const fronts = of_scenes.filter((cells) => cells.some((c) => c.front)).length;
        const least = of_scenes.map((cells) => Math.min(...cells.map((c) => c.behind)));
        const errors = of_scenes.flat().map((c) => c.error.relative_rms).filter((e) => e !== null);
        return [text(clean(t.name), t.rival ? [" ", el("small", {}, "rival")] : ""), text(clean(t.knob)), `${fronts} of ${of_scenes.length}`,
            least.length ? range_text(least, (value) => significant(value)) : "", errors.length ? range_text(errors, error_text) : "", long(clean(t.limit))];
    };
    show(el("h2", {}, "The techniques"), table(["technique", "knob", "scenes with it on the front", "its least behind", "RMS error",
        "what it comes to as its knob grows"], techniques.map(row)));
}

/* Columns that not all scenes have: a head, and its text of a cell. */
const columns_of = (scene) => [
    ...(scene.cells.some((c) => c.epipole) ? [["RMS at the light", (c) => c.epipole ? error_text(c.epipole.relative_rms) : ""]] : []),
    ...(scene.cells.some((c) => c.flicker !== undefined) ? [["flicker", (c) => error_text(c.flicker)]] : []),
    ...(drawn_cells(scene)[0]?.parts ?? []).map(({ name }, n) => [clean(name), (c) => milliseconds(c.parts[n].ms)]),
    ...(scene.cells.some((c) => c.creation_ms !== undefined) ? [["creation", (c) => milliseconds(c.creation_ms)]] : []),
    ...(has_bytes(scene) ? [["bytes a texel", (c) => c.bytes_per_texel ? significant(c.bytes_per_texel) : ""]] : [])];

function cell_row(cell, columns) {
    const name = [text(clean(cell.technique)), text(setting_of(cell))], e = cell.error, strong = (figure) => cell.front ? el("b", {}, figure) : figure;
    if (cell.refused) return [...name, "refused", ...Array(6 + columns.length).fill("")];
    return [...name, [strong(milliseconds(cell.ms.median)), el("small", {}, ` ${milliseconds(cell.ms.least)}–${milliseconds(cell.ms.greatest)}`)],
        strong(error_text(e.relative_rms)), strong(cell.front ? "front" : significant(cell.behind)), error_text(e.signed_mean),
        error_text(e.percentile_99), error_text(e.most), ...columns.map(([, of]) => of(cell)), milliseconds(cell.open_ms)];
}

function show_claims(scene) {
    for (const { what, value, paper } of scene.claims ?? [])
        show(soft(`${clean(what)}: ${significant(value)} times as long; the paper has ${significant(paper)}`));
}

function show_scene(scene) {
    const columns = columns_of(scene), file = scene.file_bytes ? [bytes(scene.file_bytes)] : [];
    show(el("h3", {}, `${scene.label}: ${[clean(scene.light), ...file].join(", ")}`),
        table(["technique", "knob", "a frame", "RMS", "behind", "mean", "99 %", "largest", ...columns.map(([head]) => head), "first frame"],
            scene.cells.map((c) => cell_row(c, columns))));
    show_claims(scene);
}

function show_figures() {
    show(el("h2", {}, "The figures"), soft("Times are medians of rounds, and least to greatest; a first frame has with it what it is made ready by. Errors "
        + "are of linear airlight, of smoke of what it takes of the light; mean, 99 % and largest are relative to the brightest pixel. Flicker is how much the error "
        + "changes while the camera moves by a third of a texel. At the light: pixels whose rays pass it within four of its radii. Creation is what a "
        + "view of one pixel takes."));
    scenes.forEach(show_scene);
}

show_head();
show(el("div", { class: "plots" }, ...scenes.flatMap(scene_figures)));
show_techniques();
show_figures();
draw_all(false);
