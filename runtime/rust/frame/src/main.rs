//! frame LEVEL.vxs LOOKUP.wgsl: the ground about the origin from above, 256 x 256 pixels of 0.25 m, lit by the first light of a level. Writes
//! frame.pgm, and says how many pixels have the answer of the processor. LOOKUP.wgsl is build/release/vxs_lookup.wgsl of `make wgsl`.
// SPDX-License-Identifier: MIT
use wgpu::util::{BufferInitDescriptor, DeviceExt};

const SIDE: u32 = 256;
const METRES: f32 = 0.25;

/// Appended to the text of the lookup: one invocation a pixel.
const SHADER: &str = "
@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<uniform> light: vxs_light_constants;
@group(0) @binding(2) var<storage, read_write> frame: array<f32>;
fn vxs_word_at(at: u32) -> u32 { return words[at]; }

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u)
{
    let place = (vec2f(id.xy) + 0.5 - 128.0) * 0.25;
    frame[id.y * 256u + id.x] = vxs_lit(light.first_word, light, vec3f(place.x, 0.0, place.y), vec3f(0.0, 1.0, 0.0), vxs_box(9));
}
";

async fn draw(light: &vxs::Light<'_>, lookup: &str) -> Result<Vec<f32>, Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::default();
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    println!("adapter: {}", adapter.get_info().name);
    let (device, queue) = adapter.request_device(&wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() }).await?;

    let words = [light.words(), &[0; 4]].concat(); // lookups may read four words behind the last
    let constants = light.constants([0.0; 3], 0);
    let constants: [u32; 24] = unsafe { std::mem::transmute(constants) };
    let buffer = |contents: &[u8], usage| device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage });
    let words = buffer(bytemuck::cast_slice(&words), wgpu::BufferUsages::STORAGE);
    let constants = buffer(bytemuck::cast_slice(&constants), wgpu::BufferUsages::UNIFORM);
    let size = u64::from(4 * SIDE * SIDE);
    let sized = |usage| device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let frame = sized(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = sized(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);

    let text = format!("{lookup}{SHADER}");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source: wgpu::ShaderSource::Wgsl(text.into()) });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let entries = [&words, &constants, &frame].map(|b| b.as_entire_binding());
    let entries: Vec<_> = (0..).zip(entries).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &pipeline.get_bind_group_layout(0), entries: &entries });

    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(SIDE / 8, SIDE / 8, 1);
    }
    encoder.copy_buffer_to_buffer(&frame, 0, &read, 0, size);
    queue.submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::Wait)?;
    let pixels = bytemuck::cast_slice(&read.slice(..).get_mapped_range()).to_vec();
    Ok(pixels)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, level, lookup] = &arguments[..] else { return Err("usage: frame LEVEL.vxs LOOKUP.wgsl".into()) };
    let level = vxs::Level::open(level)?;
    let light = level.lights().next().expect("a light");
    let pixels = pollster::block_on(draw(&light, &std::fs::read_to_string(lookup)?))?;

    let place = |n: usize| (n as f32 + 0.5 - SIDE as f32 / 2.0) * METRES;
    let at = |n: usize| [place(n % SIDE as usize).into(), 0.0, place(n / SIDE as usize).into()];
    let wanted: Vec<f32> = (0..pixels.len()).map(|n| light.lookup(at(n), Some([0.0, 1.0, 0.0]), vxs::Filter::box_of(9)).unwrap_or(-1.0)).collect();
    let same = pixels.iter().zip(&wanted).filter(|(a, b)| (**a - **b).abs() < 1e-6).count();
    let grey: Vec<u8> = pixels.iter().map(|lit| (255.0 * lit.clamp(0.0, 1.0) + 0.5) as u8).collect();
    std::fs::write("frame.pgm", [format!("P5 {SIDE} {SIDE} 255\n").as_bytes(), &grey].concat())?;
    println!("{same} of {} pixels as on the processor; mean {:.4}", pixels.len(), pixels.iter().sum::<f32>() / pixels.len() as f32);
    Ok(())
}
