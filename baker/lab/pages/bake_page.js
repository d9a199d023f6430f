/* The page of one bake. data: {report: docs/bake-report.schema.json, the rest: page.c}
 * SPDX-License-Identifier: GPL-3.0-or-later */
const report = data.report, options = report.options, estimate = report.plan.estimate, actual = report.plan.actual;
const LIGHTS_SHOWN = 30, LIGHTS_NAMED = 8, HEAD_COLOUR = "#8d8a80";
const texels_of = (light) => light.maps * light.resolution_px ** 2;
const texels = sum(report.lights, texels_of), file = report.file_bytes;
const lights = report.lights.map((light, index) => ({ ...light, index })).sort((a, b) => b.size.stored_bytes - a.size.stored_bytes);

const picture_of = (light) => data.pictures.find((p) => p.light === light.index);
const minus = (text) => text.replace("-", "\u2212");
const signed = (value) => minus(significant(Math.abs(value) < 1e-6 ? 0 : value));
const vector_text = (v) => `(${v.map(signed).join(", ")})`;

/* "sun, directional, which travels (−0.4, −0.9, −0.2), 60° above the horizon: 4096 x 4096 texels of 0.15 m" */
function light_text(light) {
    const height = -180 / Math.PI * Math.asin(Math.max(-1, Math.min(1, light.direction[1])));
    const way = { directional: `, which travels ${vector_text(light.direction)}, ${significant(height)}° above the horizon`,
        spot: `, which points along ${vector_text(light.direction)}`, point: "" }[light.kind];
    const side = light.resolution_px, maps = light.maps > 1 ? `${light.maps} maps of ` : "";
    return `${clean(light.name)}, ${light.kind}${way}: ${maps}${side} x ${side} texels of ${significant(light.texel_m)} m`;
}

/* "closed auto, region 0,0,0,1,1,1, sun noon=0,-1,0": as `--json` has them. */
function value_text(value) {
    if (typeof value === "number") return minus(significant(value, 9)); /* the requested value, not rounded */
    if (Array.isArray(value)) return value.map(value_text).join(",");
    if (value && typeof value === "object") return Object.entries(value).map(([name, v]) => `${name}=${value_text(v)}`).join(", ");
    return String(value);
}

const option_text = ([name, value]) => clean(`${name.replace(/_(m|px)$/, "").replaceAll("_", " ")} ${value_text(value)}`);

function show_made() {
    const shown = lights.slice(0, LIGHTS_NAMED).map(light_text), rest = lights.length - shown.length;
    const below = (items) => items.flatMap((item, n) => n ? [el("br", {}), item] : [item]);
    const scene = [clean(report.scene), `${count(report.casters.triangles)} triangles`, ...(data.scene_date ? [`written ${data.scene_date}`] : [])];
    show(el("h2", {}, "How it was made"), table(null, [
        [text("scene"), long(scene.join(", "))],
        [text(lights.length > 1 ? "lights" : "light"), long(below(rest ? [...shown, `and ${plural(rest, "more light")}`] : shown))],
        [text("options"), long(Object.entries(options).map(option_text).join(", "))],
        [text("by"), long(`vxs ${report.vxs}, OpenGL by ${clean(report.renderer)}`)]]));
}

function show_facts() {
    const scene = base_name(report.scene), output = report.output === "-" ? "standard output" : base_name(report.output);
    document.title = `${scene}: its bake`;
    show(el("h1", {}, `The shadows of ${scene}`),
        soft(`${count(report.casters.triangles)} triangles and ${plural(lights.length, "light")}, baked to ${output} by vxs `
            + `${report.vxs} on ${plural(options.threads, "thread")}.`),
        ...show_shadows(),
        el("div", { class: "facts" },
            fact("How big?", bytes(file), `on disk; planned ${bytes(estimate.file_bytes)}`),
            fact("For a texel?", `${significant(8 * file / texels)} bit`, `a 16-bit depth map takes ${count(2 * texels / file)} times as much`),
            fact("When loaded?", bytes(actual.memory_bytes), `in memory; planned ${bytes(estimate.memory_bytes)}`),
            fact("How long?", seconds(report.total_seconds), `to bake; planned ${seconds(estimate.total_seconds)}`),
            fact("How much memory?", bytes(report.peak_bytes), `at the peak; planned ${bytes(estimate.peak_bytes)}`)));
}

/* The results, next to the picture of the largest light. */
function show_shadows() {
    const light = lights.find(picture_of), depths = light && picture_of(light).depths;
    const seen = light && el("figure", {}, el("img", { src: depths, alt: "depth map, near surfaces light" }),
        el("figcaption", {}, `What ${clean(light.name)} sees: near is light, no caster is blank.`));
    if (!data.shadows)
        return [soft("There is no picture of the shadows: it would have needed more memory than the bake may hold."), ...(seen ? [seen] : [])];
    const few = lights.length > data.shadow_lights ? `, of the ${data.shadow_lights} largest lights` : "";
    return [el("div", { class: light && light.maps > 1 ? "pairs" : "shadows" },
        el("figure", {}, el("img", { src: data.shadows, alt: "the scene in its shadows" }),
            el("figcaption", {}, `The scene in its shadows${few}, looked up in the file. All else is traced.`)), ...(seen ? [seen] : []))];
}

const is_dag = options.coding !== "blocks";

/* Sums over all lights, the finest level first; of palette blocks, by kind. */
function sum_levels() {
    const levels = [];
    for (const level of report.lights.flatMap((light) => light.levels)) {
        const n = !is_dag ? ["pages", "patterns", "tops"].indexOf(level.kind) : level.kind === "masks" ? 0 : Math.log2(level.side_voxels);
        levels[n] ??= { n, kind: level.kind, count: 0, stored_bytes: 0, memory_bytes: 0 };
        for (const figure of ["count", "stored_bytes", "memory_bytes"]) levels[n][figure] += level[figure];
    }
    return levels.filter((level) => level.count);
}

function show_levels() {
    const levels = sum_levels(), head = file - sum(levels, (l) => l.stored_bytes);
    const of_kind = (kind) => sum(levels, (l) => l.kind === kind ? l.count : 0);
    const parts = levels.map((l) => ({ name: is_dag ? level_name(l.n) : l.kind, size: l.stored_bytes, colour: level_colour(l.n),
        count: count(l.count), memory: bytes(l.memory_bytes) }));
    parts.push({ name: "head", size: head, colour: HEAD_COLOUR, count: "", memory: "" });
    const piece = ({ name, size, colour }) => el("i", { style: `width: ${100 * size / file}%; background: ${colour}`,
        title: `${name}: ${bytes(size)}, ${percent(size / file)}` });
    const row = ({ name, size, colour, count, memory }) =>
        [text(name), count, bytes(size), bar(size / file, `background: ${colour}`), percent(size / file), memory];
    show(el("h2", {}, "Where the bytes go"), el("div", { class: "stack" }, ...parts.map(piece)));
    const parts_table = (head) => table([head, "count", "on disk", "share of the file", "", "in memory"], parts.map(row));
    if (!is_dag) {
        show(soft("Tops say for 256 x 256 texels at once whether they have one depth, or where to look; that, and patterns that several pages "
                + "use, is one part of the file. Pages hold the rest, and can be read one by one."), parts_table("part"),
            el("p", {}, `${count(sum(lights, (l) => l.mask_tiles))} of ${count(texels / 64)} tiles of 8 x 8 texels need patterns, because no `
                + "single depth parts them into light and shadow."));
        return;
    }
    show(soft("The file from its finest level to its coarsest. Masks say of 8 x 8 texels at one depth which are dark; nodes of n³ voxels "
            + "say where which masks and smaller nodes lie. Equal ones are stored once."),
        parts_table("level"),
        el("p", {}, `${count(sum(lights, (l) => l.mask_tiles))} of ${count(texels / 64)} tiles of 8 x 8 texels need masks, because no `
            + `single depth parts them into light and shadow; they need ${count(sum(lights, (l) => l.mask_runs))}, of which `
            + `${count(of_kind("masks"))} differ and are stored. Of ${count(sum(lights, (l) => l.inserted_nodes))} nodes `
            + `${count(of_kind("nodes"))} are left.`));
}

function show_lights() {
    const rest = lights.slice(LIGHTS_SHOWN), heads = ["light", "kind", "maps", "texels a side", "of a texel", "on disk",
        "share of the file", "in memory", "bit/texel", ...(is_dag ? ["tiles with masks", "masks needed"] : ["tiles with patterns"])];
    const row = ({ size, ...l }) => [text(clean(l.name)), text(l.kind), count(l.maps), String(l.resolution_px),
        `${significant(l.texel_m)} m`, bytes(size.stored_bytes), bar(size.stored_bytes / file), bytes(size.memory_bytes),
        size.stored_bit_per_texel.toFixed(3), count(l.mask_tiles), ...(is_dag ? [count(l.mask_runs)] : [])];
    show(el("h3", {}, "By light"), table(heads, lights.slice(0, LIGHTS_SHOWN).map(row)));
    if (rest.length) show(soft(`${rest.length} smaller lights take ${bytes(sum(rest, (l) => l.size.stored_bytes))} together.`));
}

/* "+y", or a vector if it is no axis of the world. */
function axis_text(axis, sign) {
    const way = axis.map((value) => sign * value), n = way.findIndex((value) => Math.abs(value) > 0.9999);
    return n < 0 ? vector_text(way) : `${way[n] < 0 ? "\u2212" : "+"}${"xyz"[n]}`;
}

/* The directions of the faces of a light's six maps, in the layout of its pictures. */
function faces_text([x, y, z]) {
    return "The six maps lie as a cube that is unfolded, as the light sees it. In the row: "
        + `${[axis_text(x, 1), axis_text(z, 1), axis_text(x, -1), axis_text(z, -1)].join(", ")}; above ${axis_text(y, 1)}, below ${axis_text(y, -1)}.`;
}

function show_pictures() {
    if (is_dag) show(el("h2", {}, "What the light sees, and where it takes masks"),
        el("p", {}, "On the left the map's depths, as the light sees them: near is light, no caster is blank. On the right the same "
            + "place, coloured where shadows take masks: there, and in the nodes above them, the bytes go. Edges of shadows, leaves, "
            + "grass and wires show; so do sheets, whose every slope is an edge."),
        key(["masks that an 8 x 8 tile needs:"], ...data.mask_colours.map(([name, colour]) => [swatch(colour), name])));
    else show(el("h2", {}, "What the light sees"), soft("The map's depths: near is light, no caster is blank."));
    for (const light of lights) {
        const picture = picture_of(light), side = light.resolution_px;
        if (!picture) continue;
        const size = `${plural(light.maps, "map")} of ${side} x ${side} texels, ${bytes(light.size.stored_bytes)}`;
        const figure = (what, src, alt) => el("figure", {}, el("h3", {}, what),
            el("img", { src, alt, class: picture.side_px < 512 ? "few" : "" }));
        show(el("h3", {}, `${clean(light.name)}: ${size}`), el("div", { class: "pairs" },
            figure("Depths", picture.depths, "depth map, near surfaces light"),
            ...(is_dag ? [figure("Masks", picture.masks, "the same place: how many masks its tiles need")] : [])));
        if (light.maps > 1) show(soft(faces_text(picture.axes)));
        if (is_dag && picture.mask_tiles > 1)
            show(soft(`A pixel stands for ${picture.mask_tiles} tiles: the one that needs most of them counts.`));
    }
    if (data.pictures.length < lights.length) show(soft(`${lights.length - data.pictures.length} more lights are not pictured.`));
}

const code = (words) => el("code", {}, words);

function sheet_hint() {
    const casters = report.casters, sheets = casters.triangles - casters.solids.triangles;
    const [kind, most] = Object.entries(casters.sheets).reduce((a, b) => b[1].triangles > a[1].triangles ? b : a);
    return sheets >= casters.triangles / 20 && [
        `${percent(sheets / casters.triangles)} of the triangles are sheets. Only solids have an inside, where voxels are don't-care: the `
        + `builder is free to choose what repeats. Most of these, ${count(most.triangles)}, are ${kind}: `, code("vxs health"),
        " names them, and ", code("vxs mend"), " closes what can be closed."];
}

/* Options that make a light of this kind smaller. */
function light_hint(light) {
    if (light.kind === "spot") return ["A narrower cone or a shorter range reaches fewer casters."];
    if (light.kind === "point") return ["A shorter range reaches fewer casters."];
    return ["Its map may be smaller than others: ", code(`--resolution ${clean(light.name)}=${light.resolution_px / 2}`), "."];
}

function show_hints() {
    const half = Math.max(...lights.map((l) => l.resolution_px)) / 2, largest = lights[0];
    const hints = [
        options.closed === "off" ? [code("--closed off"), " makes a sheet of every solid; without it they are told apart."] : sheet_hint(),
        options.rule === "shadow" && [code("--rule greedy"), " takes the fewest masks."],
        options.reuse === "off" && [code("--reuse on"), " does not make again what equals its neighbour."],
        is_dag && options.stop !== "final" && [code("--stop final"), " merges what is equal."],
        options.exit === "back" && [code("--exit auto"), " looks for the exit of the union where solids meet."],
        lights.length > 1 && [`The largest light, ${clean(largest.name)}, takes ${percent(largest.size.stored_bytes / file)} of the file. `,
            ...light_hint(largest)],
        !options.region_m && lights.some((l) => l.kind === "directional") && [code("--region"), " bakes only the box that will be looked up; all of the scene still casts into it."],
        half >= 8 && ["Half the resolution, ", code(`--resolution ${half}`), ": shadows end in lines and surfaces, so a file is often "
            + "about half as large then. ", code("vxs plan"), " estimates it."],
        is_dag && [code("--coding blocks"), " keeps maps in about a third of the bytes, and a quarter of the memory."],
        options.pack === "fast" && [code("--pack small"), " takes about three fifths of the bytes, and opens some eight times slower."],
        (is_dag || options.pack === "fast") && options.zstd_level < 19 && [code("--level 19"), " compresses harder, and takes longer to write."],
    ];
    show(el("h2", {}, "What would make it smaller"), list(hints.filter(Boolean)));
}

function show_stages() {
    const planned = Object.fromEntries(estimate.stages.map((s) => [s.name, s.seconds]));
    const most = Math.max(...report.stages.map((s) => Math.max(s.seconds, planned[s.name])));
    const both = (took, plan) => {
        const cell = bar(took / most);
        cell.append(el("u", { style: `width: ${100 * plan / most || 0}%` }));
        return cell;
    };
    show(el("h2", {}, "Where the time goes"), soft("Broad bars are what it took, narrow ones what was planned."),
        table(["stage", "took", "planned", "", "peak memory"], report.stages.filter((s) => s.seconds || planned[s.name]).map((s) =>
            [text(s.name), seconds(s.seconds), seconds(planned[s.name]), both(s.seconds, planned[s.name]), bytes(s.peak_bytes)]),
        [text("total"), seconds(report.total_seconds), seconds(estimate.total_seconds), "", bytes(report.peak_bytes)]));
}

function show_decisions() {
    show(el("h2", {}, "What was decided, and why"),
        table(null, report.plan.decisions.map((d) => [text(d.name), text(clean(d.choice)), long(clean(d.reason))])));
}

function show_casters() {
    const casters = report.casters, size = casters.max_m.map((max, n) => significant(max - casters.min_m[n], 4));
    const kinds = [["solids", casters.solids], ...Object.entries(casters.sheets).map(([kind, k]) => [`sheets: ${kind}`, k])];
    show(el("h2", {}, "What casts shadows"),
        table(["components", "how many", "triangles", ""], kinds.filter(([, k]) => k.components).map(([name, k]) =>
            [text(name), count(k.components), count(k.triangles), bar(k.triangles / casters.triangles)])),
        soft(`They fill ${size.join(" x ")} m.`));
}

function show_left_out() {
    const left_out = report.lights_left_out, shown = left_out.slice(0, LIGHTS_SHOWN).map((l) => clean(`${l.name}: ${l.why}`));
    if (left_out.length > LIGHTS_SHOWN) shown.push(`and ${left_out.length - LIGHTS_SHOWN} more`);
    if (left_out.length) show(el("h2", {}, "Lights left out"), list(shown));
    if (report.warnings.length) show(el("h2", {}, "Warnings"), list(report.warnings.map(clean)));
}

show_facts();
show_made();
show_levels();
show_lights();
show_pictures();
show_hints();
show_stages();
show_decisions();
show_casters();
show_left_out();
