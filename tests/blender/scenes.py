# The corpus: small scenes as people make them in Blender, built by its Python alone. Runs inside Blender 3.4 and later.
# SPDX-License-Identifier: GPL-3.0-or-later
import math
import random

import bmesh
import bpy
from mathutils import Matrix, Vector

NEW_ALPHA = bpy.app.version >= (4, 2, 0)  # EEVEE has no blend_method: nodes clip alpha


def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def place(data, name, at=(0, 0, 0), turn=(0, 0, 0), scale=(1, 1, 1), collection=None, parent=None):
    """A new object; `turn` in degrees."""
    made = bpy.data.objects.new(name, data)
    made.location, made.scale = at, scale
    made.rotation_euler = [math.radians(degrees) for degrees in turn]
    made.parent = parent
    (collection or bpy.context.scene.collection).objects.link(made)
    return made


def mesh_of(name, fill, material=None):
    """A mesh that `fill` makes of an empty BMesh."""
    shape = bmesh.new()
    fill(shape)
    mesh = bpy.data.meshes.new(name)
    shape.to_mesh(mesh)
    shape.free()
    if material:
        mesh.materials.append(material)
    return mesh


def box(name="box", size=(1, 1, 1), material=None):
    """A box that stands on z = 0."""
    matrix = Matrix.Translation((0, 0, size[2] / 2)) @ Matrix.Diagonal((*size, 1))
    return mesh_of(name, lambda shape: bmesh.ops.create_cube(shape, size=1, matrix=matrix), material)


def floor(side, name="floor", height=lambda x, y: 0.0, cells=1):
    def fill(shape):
        bmesh.ops.create_grid(shape, x_segments=cells, y_segments=cells, size=side / 2)
        for vertex in shape.verts:
            vertex.co.z = height(vertex.co.x, vertex.co.y)

    return place(mesh_of(name, fill), name)


def ball(radius, name="ball", segments=24):
    """The same faces in the same order each time, which bmesh.ops.create_uvsphere does not promise and decimation needs."""
    rings = segments // 2
    across = [[(math.sin(math.pi * i / rings) * math.cos(2 * math.pi * j / segments),
                math.sin(math.pi * i / rings) * math.sin(2 * math.pi * j / segments),
                math.cos(math.pi * i / rings)) for j in range(segments)] for i in range(1, rings)]
    points = [Vector(point) * radius for point in [(0, 0, 1), *(point for ring in across for point in ring), (0, 0, -1)]]
    last, faces = len(points) - 1, []
    for j in range(segments):
        k = (j + 1) % segments
        faces += [(0, 1 + j, 1 + k), (last, last - segments + k, last - segments + j)]
        faces += [(1 + (i + 1) * segments + j, 1 + (i + 1) * segments + k, 1 + i * segments + k, 1 + i * segments + j)
                  for i in range(rings - 2)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    return mesh


def cone(name, low, high, depth, caps):
    return mesh_of(name, lambda shape: bmesh.ops.create_cone(
        shape, cap_ends=caps, segments=20, radius1=low, radius2=high, depth=depth))


def card(name, material, side=1.0):
    """A square with texture coordinates."""
    def fill(shape):
        bmesh.ops.create_grid(shape, x_segments=1, y_segments=1, size=side / 2)
        uv = shape.loops.layers.uv.new("UVMap")
        for face in shape.faces:
            for loop in face.loops:
                loop[uv].uv = (loop.vert.co.x / side + 0.5, loop.vert.co.y / side + 0.5)

    return mesh_of(name, fill, material)


def lamp(kind, name, at=(0, 0, 0), turn=(0, 0, 0), energy=100.0, degrees=None, blend=0.15, **more):
    """`more` goes to place()."""
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    if degrees:
        data.spot_size, data.spot_blend = math.radians(degrees), blend
    return place(data, name, at, turn, **more)


def sun(turn=(40, 10, 30), name="sun"):
    return lamp("SUN", name, (0, 0, 20), turn, 3.0)


def collection(name, linked):
    made = bpy.data.collections.new(name)
    if linked:
        bpy.context.scene.collection.children.link(made)
    return made


def instance_of(of, name, **where):
    made = place(None, name, **where)
    made.instance_type, made.instance_collection = "COLLECTION", of
    return made


# scenes --------------------------------------------------------------------------------------------------------------------------


def instances():
    """Collections in collections, turned, scaled, with an offset."""
    floor(40)
    hut = collection("hut", False)
    place(box("walls", (3, 2, 2)), "walls", collection=hut)
    place(cone("roof", 2.3, 0, 1.5, True), "roof", (0, 0, 2.8), collection=hut)
    hut.instance_offset = (0.5, 0, 0)
    yard = collection("yard", False)
    place(box("post", (0.3, 0.3, 3)), "post", (3, 3, 0), collection=yard)
    instance_of(hut, "hut in yard", turn=(0, 0, 30), scale=(0.7, 0.7, 1), collection=yard)
    for n in range(6):
        at = (12 * math.cos(n), 12 * math.sin(n), 0)
        instance_of(yard if n % 2 else hut, f"place {n}", at=at, turn=(0, 0, 50 * n), scale=(1, 1, 1 + n / 4))
    sun()


def mirrored():
    """Negative scales, of one axis and of three, and a mirror modifier."""
    floor(16)

    def wedge(shape):
        bmesh.ops.create_cube(shape, size=1)
        for vertex in shape.verts:
            if vertex.co.x > 0 and vertex.co.z > 0:
                vertex.co.z = -0.2

    mesh = mesh_of("wedge", wedge)
    place(mesh, "left", (-3, 0, 1), scale=(-1.5, 1, 2))
    place(mesh, "turned", (3, 2, 1), (0, 30, 20), (-1, -1, -1))
    pair = place(mesh, "pair", (2, -3, 1), scale=(1, 1, 1.6))
    mirror = pair.modifiers.new("mirror", "MIRROR")
    mirror.use_axis = (True, True, False)
    mirror.mirror_object = place(None, "middle", (0.5, -2, 0))
    parent = place(None, "flipped", (-4, -4, 0), scale=(1, -1, 1))
    place(mesh, "child", (0, 1, 1.2), (0, 0, 40), parent=parent)
    lamp("SPOT", "spot", (0, -1, 9), (10, 5, 0), degrees=75, blend=0.4)
    sun((-35, 20, 0))


def array():
    """Fences and stairs by array modifiers, one with an object for its offset."""
    floor(24)
    fence = place(box("slat", (0.15, 0.05, 1.5)), "fence", (-8, 2, 0))
    rows = fence.modifiers.new("row", "ARRAY")
    rows.count, rows.relative_offset_displace = 40, (2.4, 0, 0)
    stairs = place(box("step", (2, 0.5, 0.3)), "stairs", (3, -6, 0))
    steps = stairs.modifiers.new("steps", "ARRAY")
    steps.count, steps.use_relative_offset, steps.use_object_offset = 10, False, True
    steps.offset_object = place(None, "next", (3.1, -5.5, 0.35), (0, 0, 12))
    lamp("POINT", "bulb", (-3, -4, 4))
    sun((50, 0, 40))


def decimated():
    """A hill and a rock that decimate modifiers have cut to slivers."""
    hill = floor(30, "hill", lambda x, y: 1.5 * math.sin(x / 3) * math.cos(y / 4), 60)
    hill.modifiers.new("fewer", "DECIMATE").ratio = 0.15
    rock = place(ball(2, "rock", 40), "rock", (1, 2, 3), scale=(1.3, 0.8, 1))
    rock.modifiers.new("fewer", "DECIMATE").ratio = 0.1
    bump = rock.modifiers.new("rough", "DISPLACE")
    bump.strength, bump.mid_level = 0.4, 0.0
    sun((55, 15, 0))


def boolean():
    """Walls with windows cut by boolean modifiers; the cutters are hidden in renders, or lie in a hidden collection."""
    floor(20)
    walls = place(box("walls", (8, 6, 3)), "walls")
    hidden = collection("cutters", True)
    hidden.hide_render = True
    cutters = [place(box("inside", (7.6, 5.6, 2.7)), "inside", (0, 0, 0.1))]
    cutters += [place(box("window", (1, 9, 1.2)), f"window {n}", (2.4 * n - 2.4, 0, 1), collection=hidden) for n in range(3)]
    cutters[0].hide_render = True
    for cutter in cutters:
        cutter.display_type = "WIRE"
        cut = walls.modifiers.new(cutter.name, "BOOLEAN")
        cut.operation, cut.solver, cut.object = "DIFFERENCE", "EXACT", cutter
    out_of_view = place(box("unseen", (9, 9, 9)), "unseen")
    out_of_view.hide_viewport = True
    lamp("POINT", "inside lamp", (1.5, 0.5, 2))
    sun((60, 0, 20))


def centimetres():
    """A room in centimetres, with Blender's unit scale set so."""
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = "METRIC", 0.01
    floor(600)
    place(box("table", (140, 80, 4)), "table", (0, 0, 70))
    for n in range(4):
        place(box("leg", (6, 6, 70)), f"leg {n}", (120 * (n % 2) - 60, 60 * (n // 2) - 30, 0))
    place(box("wall", (400, 10, 250)), "wall", (0, 150, 0))
    lamp("POINT", "lamp", (30, -40, 210), energy=1e6)
    sun((35, 25, 0))


def leaf_image(side=64):
    """A leaf with teeth, smooth at its edge: alpha of an image that is packed into the file."""
    image = bpy.data.images.new("leaf", side, side, alpha=True)
    pixels = []
    for y in range(side):
        for x in range(side):
            u, v = 2 * (x + 0.5) / side - 1, 2 * (y + 0.5) / side - 1
            edge = 0.75 + 0.2 * math.cos(7 * math.atan2(v, u)) - math.hypot(u, v)
            pixels += [0.2, 0.6, 0.1, min(1, max(0, 0.5 + 8 * edge))]
    image.pixels = pixels
    image.file_format = "PNG"
    image.pack()
    return image


def leaf_material(name, image, clip=None, blended=False):
    """Alpha that is clipped at a threshold, hashed, or blended: by the old setting, or by nodes where it is gone."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    texture, shader = nodes.new("ShaderNodeTexImage"), nodes["Principled BSDF"]
    texture.image = image
    links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    alpha = texture.outputs["Alpha"]
    if NEW_ALPHA:
        material.surface_render_method = "BLENDED" if blended else "DITHERED"
        if clip is not None:
            math_node = nodes.new("ShaderNodeMath")
            math_node.operation = "GREATER_THAN"
            math_node.inputs[1].default_value = clip
            links.new(alpha, math_node.inputs[0])
            alpha = math_node.outputs[0]
    else:
        material.blend_method = "CLIP" if clip is not None else "BLEND" if blended else "HASHED"
        material.alpha_threshold = 0.5 if clip is None else clip
    links.new(alpha, shader.inputs["Alpha"])
    material["clip"] = 0.5 if clip is None else clip
    return material


def leaves():
    """Cards of leaves: clipped at 0.3, hashed, and blended."""
    floor(12)
    image = leaf_image()
    materials = [leaf_material("clip", image, clip=0.3), leaf_material("hashed", image), leaf_material("blend", image, blended=True)]
    cards = [card(material.name, material, 1.4) for material in materials]
    draw = random.Random(5)
    for n in range(36):
        at = (draw.uniform(-4, 4), draw.uniform(-4, 4), draw.uniform(1, 4))
        place(cards[n % 3], f"leaf {n}", at, [draw.uniform(-60, 60) for _ in range(3)])
    lamp("POINT", "lantern", (0.5, 0.3, 6))
    sun((20, 15, 0))


def lamps():
    """Lamps in shades, spots with blend, one on a parent that is scaled, one with a range."""
    floor(20)
    place(box("wall", (20, 0.2, 4)), "wall", (0, 6, 0))
    for n in range(3):
        at = (5 * n - 5, 1, 2.5)
        place(cone(f"shade {n}", 0.8, 0.35, 0.7, False), f"shade {n}", at)
        lamp("POINT", f"bulb {n}", at)
        place(box("table", (1, 1, 0.8)), f"table {n}", (at[0] + 0.8, 0.5, 0))
    for n, (degrees, blend) in enumerate(((40, 0), (70, 0.5), (110, 1))):
        lamp("SPOT", f"spot {n}", (5 * n - 5, -2, 4), (35, 5 * n, 0), degrees=degrees, blend=blend)
    arm = place(None, "arm", (0, -6, 0), (0, 0, 45), (2, 2, 2))
    lamp("SPOT", "on arm", (0, 0, 2), (50, 0, 0), degrees=60, parent=arm)
    short = lamp("POINT", "short", (-6, -6, 1.5))
    short.data.use_custom_distance, short.data.cutoff_distance = True, 4.0


def dome():
    """A scene in the sun, under a dome of sky that Cycles does not let cast shadow."""
    floor(30)
    for n in range(5):
        place(box("tower", (2, 2, 3 + n)), f"tower {n}", (5 * n - 10, 3 * (n % 2), 0))
    sky = place(ball(60, "sky", 32), "sky")
    sky.visible_shadow = False
    sun((45, 0, 15))


def many():
    """300 objects with shared meshes, a third of them parented, some in hidden collections."""
    floor(60)
    meshes = [box("crate"), ball(0.6, "boulder", 12), cone("tree", 0.8, 0, 2.5, True)]
    draw = random.Random(1)
    store = collection("store", True)
    store.hide_viewport = True
    parent = None
    for n in range(300):
        size, at = draw.uniform(0.5, 1.8), (draw.uniform(-28, 28), draw.uniform(-28, 28), draw.uniform(0, 0.4))
        made = place(meshes[n % 3], f"object {n}", at, (0, 0, draw.uniform(0, 360)), (size, size, size * draw.uniform(0.7, 1.6)),
                     collection=store if n % 25 == 24 else None)
        if n % 3 == 2 and parent:
            made.parent, made.matrix_parent_inverse = parent, parent.matrix_basis.inverted()
        if n % 10 == 0:
            parent = made
    lamp("SPOT", "mast", (0, 0, 22), (8, 0, 0), degrees=80)
    sun((50, 20, 10))


def particles():
    """Hair that draws a shrub."""
    ground = floor(20, cells=8)
    shrub = place(cone("shrub", 0.4, 0, 1, True), "shrub", (0, 0, -30), (0, 90, 0))
    ground.modifiers.new("shrubs", "PARTICLE_SYSTEM")
    hair = ground.particle_systems[0].settings
    hair.type, hair.count, hair.render_type, hair.instance_object = "HAIR", 60, "OBJECT", shrub
    hair.particle_size, hair.size_random, hair.use_advanced_hair = 1.0, 0.4, True
    sun((35, -20, 0))


def emitted():
    """Emitted particles that draw a collection."""
    floor(20)
    stones = collection("stones", True)
    for n in range(2):
        place(ball(0.25 + 0.1 * n, f"stone {n}", 8), f"stone {n}", (n, 0, -20), collection=stones)
    tray = place(mesh_of("tray", lambda shape: bmesh.ops.create_grid(shape, x_segments=3, y_segments=3, size=3)), "tray", (0, 0, 3))
    tray.modifiers.new("stones", "PARTICLE_SYSTEM")
    shed = tray.particle_systems[0].settings
    shed.count, shed.frame_start, shed.frame_end, shed.lifetime = 40, 1, 1, 100
    shed.physics_type, shed.render_type, shed.instance_collection = "NO", "COLLECTION", stones
    shed.particle_size = 1.0
    sun((35, -20, 0))


def node_group(name):
    group = bpy.data.node_groups.new(name, "GeometryNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.inputs.new("NodeSocketGeometry", "Geometry")
        group.outputs.new("NodeSocketGeometry", "Geometry")
    return group


def nodes():
    """Geometry nodes: instances of an object on the points of a grid, scaled at random, beside the grid itself."""
    floor(30)
    pole = place(box("pole", (0.3, 0.3, 2)), "pole", (0, 0, 0))
    pole.hide_render = pole.hide_viewport = True
    group = node_group("scatter")
    new, link = group.nodes.new, group.links.new
    enter, leave = new("NodeGroupInput"), new("NodeGroupOutput")
    source, scatter, join = new("GeometryNodeObjectInfo"), new("GeometryNodeInstanceOnPoints"), new("GeometryNodeJoinGeometry")
    size = new("FunctionNodeRandomValue")
    source.inputs["Object"].default_value = pole
    size.inputs[2].default_value, size.inputs[3].default_value = 0.5, 1.5
    link(enter.outputs[0], scatter.inputs["Points"])
    link(source.outputs["Geometry"], scatter.inputs["Instance"])
    link(size.outputs[1], scatter.inputs["Scale"])
    link(scatter.outputs[0], join.inputs[0])
    link(enter.outputs[0], join.inputs[0])
    link(join.outputs[0], leave.inputs[0])
    grid = mesh_of("grid", lambda shape: bmesh.ops.create_grid(shape, x_segments=6, y_segments=6, size=8))
    field = place(grid, "field", (0, 0, 1.5), (6, 0, 10))
    field.modifiers.new("scatter", "NODES").node_group = group
    sun((40, 10, 30))


def shapes():
    """What is no mesh: a pipe along a curve, letters, a metaball, a surface."""
    floor(16)
    path = bpy.data.curves.new("pipe", "CURVE")
    path.dimensions, path.bevel_depth, path.resolution_u = "3D", 0.25, 6
    spline = path.splines.new("BEZIER")
    spline.bezier_points.add(2)
    for point, at in zip(spline.bezier_points, ((-5, 2, 0), (0, 3, 4), (5, 1, 0.5))):
        point.co, point.handle_left_type, point.handle_right_type = at, "AUTO", "AUTO"
    place(path, "pipe")
    text = bpy.data.curves.new("letters", "FONT")
    text.body, text.extrude, text.size = "vxs", 0.2, 3
    place(text, "letters", (-3, -3, 1), (80, 0, 10))
    drop = bpy.data.metaballs.new("drop")
    for at in ((0, 0, 0), (0.9, 0, 0.3)):
        drop.elements.new().co = at
    place(drop, "drop", (4, -3, 1.5))
    sun((40, -15, 20))


def sheared():
    """Boxes turned below a parent of unequal scale, as nodes can have it; and boxes that kept their place when they got such a parent:
    no translation, rotation and scale does that."""
    floor(16)
    stretched = place(None, "stretched", (0, 0, 0), (0, 0, 30), (3, 1, 1))
    bpy.context.view_layer.update()
    for n in range(4):
        beam = place(box("beam", (0.4, 0.8, 2.5)), f"beam {n}", (2 * n - 4, 3 * (n % 2), 1), (20 * n, 30, 40), parent=stretched)
        if n % 2:
            beam.matrix_parent_inverse = stretched.matrix_world.inverted()
            beam.location.y -= 4
    sun((35, 15, 0))


def movers():
    """What the add-on leaves out: movers and their children, what is animated or deformed, and what is asked not to cast."""
    floor(20)
    mesh = box("crate")
    place(mesh, "stays", (-6, -3, 0))
    moving = collection("moving", True)
    door = place(mesh, "door", (-3, -3, 0), collection=moving)
    place(mesh, "knob", (0, 0, 1.2), parent=door)
    lift = place(mesh, "lift", (0, -3, 0))
    for frame, height in ((1, 0), (40, 3)):
        lift.location.z = height
        lift.keyframe_insert("location", frame=frame)
    place(mesh, "on lift", (0, 0, 1), (0, 0, 45), parent=lift)
    place(mesh, "unseen by lamps", (3, -3, 0)).visible_shadow = False
    place(mesh, "no caster", (6, -3, 0))["vxs_cast_shadow"] = False
    bones = bpy.data.objects.new("bones", bpy.data.armatures.new("bones"))
    bpy.context.scene.collection.objects.link(bones)
    figure = place(mesh, "figure", (-3, 3, 0))
    figure.modifiers.new("bones", "ARMATURE").object = bones
    place(mesh, "set not to cast", (0, 3, 0))
    place(mesh, "still", (3, 3, 0)).keyframe_insert("location", frame=1)
    sun((40, 20, 0))


SCENES = {build.__name__: build for build in (instances, mirrored, array, decimated, boolean, centimetres, leaves, lamps, dome, many,
                                              particles, emitted, nodes, shapes, sheared, movers)}


def large(triangles, objects):
    """Hills of one mesh, or as many objects that share a mesh; returns how many triangles there are."""
    empty_file()
    sun()
    side = max(1, round((triangles / objects / 2) ** 0.5))
    hills = floor(100 / objects ** 0.5, "hills", lambda x, y: 3 * math.sin(x / 5) * math.cos(y / 7), side)
    row = math.ceil(objects ** 0.5)
    for n in range(1, objects):
        place(hills.data, f"hills {n}", (n % row * 100 / row, n // row * 100 / row, n % 7), (0, 0, n))
    bpy.context.view_layer.update()
    return 2 * side * side * objects


def make(name):
    empty_file()
    bpy.context.scene.name = name
    SCENES[name]()
    bpy.context.view_layer.update()
