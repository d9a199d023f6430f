//! As `vxs query FILE.vxs --filter 9`: lines of x y z nx ny nz on standard input, a line of answers for each.
use std::io::{stdin, BufRead};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let level = vxs::Level::open(std::env::args().nth(1).ok_or("usage: query FILE.vxs < points")?)?;
    for line in stdin().lock().lines() {
        let n: Vec<f64> = line?.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let answers = level.lights().map(|light| light.lookup([n[0], n[1], n[2]], Some([n[3], n[4], n[5]]), vxs::Filter::box_of(9)));
        println!("{}", answers.map(|lit| lit.map_or("out".into(), |lit| lit.to_string())).collect::<Vec<_>>().join(" "));
    }
    Ok(())
}
