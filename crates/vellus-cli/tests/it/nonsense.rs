//! Bad input is rejected before any work, with exit code 2, one message, and no file.

use crate::common::vellus;
use std::time::{Duration, Instant};

/// To start and to read the shipped tables takes less time, even on a busy machine. To grow the smallest scene takes
/// more.
const LIMIT: Duration = Duration::from_secs(2);

/// Commands, and a part of their message.
const COMMANDS: &str = "
render nonsense | neither a built-in scene
render --frame 3 | the built-in scene raccoon has its own
render --frames 1-2 | the built-in scene raccoon has its own
render --fiber unicorn | unknown preset 'unicorn'
render cat --set kapa=0.5 | in --set kapa=0.5: unknown parameter 'kapa'
render cat --set kappa=2 | in --set kappa=2: kappa = 2
render cat --override | --override needs --fiber or --set
render x.usda --override | --override needs --fiber or --set
render cat --view 1 | a view is YAW,PITCH
render cat --view 0,90 | pitch in [-89, 89]
render cat --view 0,0,nan | zoom in [0.01, 100]
render x.usda --view 0,0 --camera c | --camera and --view exclude each other
render cat --light moon | it must be studio, sun, sky
render cat --light x.hdr | cannot read x.hdr
render cat --background blurple | a colour (a name, #rrggbb or R,G,B)
render cat --background #12345 | a colour (a name, #rrggbb or R,G,B)
render cat --background x.png | cannot read x.png
render cat --body x.obj | cannot read x.obj
render cat --body x.hair | --body x.hair: it must be a .obj
render ball.obj --camera c | for USD and Alembic files
render cat --width 1 | the built-in scene cat has its own
render cat --model yan2015 --eta-m 99 | eta_m = 99 is out of range: eta_m must be in [1, 3]
render cat --model yan2015 --eta-m nan | eta_m = NaN
render cat --eta-m 1.5 | only yan2015 takes two
render cat --model phong | unknown model 'phong'
render cat -o x.txt | end in .exr or .png
render cat -o . | end in .exr or .png
render cat --size 0x5 | [1, 32768]
render cat --size -1x5 | [1, 32768]
render cat --crop -1,0,5,5 | X,Y,W,H
render cat --crop 0,0,5000,5 | not within
render cat --spp -1 | whole number in [1, 2147483647]
render cat --spp 0 | whole number in [1, 2147483647]
render cat --spp 1e3 | whole number in [1, 2147483647]
render cat --time -5s | 60s, 5m or 2h
render cat --time inf | 60s, 5m or 2h
render cat --noise nan | finite number above 0
render cat --noise -1 | finite number above 0
render cat --noise inf | finite number above 0
render cat --samples 5..5 | A < B
render cat --samples -1..5 | A < B
render x.usda --frames -2147483648-2147483647 | 4294967296 frames: at most 1000000
render x.usda --frames 0-1000000 | at most 1000000
render x.usda --frame nan | finite
render x.usda --frame -inf | finite
render x.usda --width nan | finite number above 0
render x.usda --width -1 | finite number above 0
render x.usda --fiber nope | unknown preset 'nope'
render x.usda --set kappa=2 | in --set kappa=2: kappa = 2
render x.usda --set kappa | NAME=VALUE
render x.usda | x.usda
render x.hair --camera c | for USD and Alembic files
render x.tfx | cannot read x.tfx
render cat --clamp-indirect 0 | a radiance is above 0
render cat --max-depth -1 | whole number in [0, 4294967295]
render cat --min-pixel-width -1 | [0, 100] pixels
render cat --lod full | auto, off, or a number in [-8, 8]
render cat --lod nan | auto, off, or a number in [-8, 8]
render cat --lod -9 | auto, off, or a number in [-8, 8]
render cat --seed 5000000000 | whole number in [0, 4294967295]
render cat --threads 0 | whole number in [1, 
render cat --threads -1 | whole number in [1, 
render cat --threads 100000 | whole number in [1, 
render cat --exposure nan | finite number in [-100, 100]
render cat --exposure -inf | finite number in [-100, 100]
render cat --exposure 1e9 | finite number in [-100, 100], or auto
render cat --tone filmic | neutral, agx, srgb
render cat --reflectance-of all | groom, dense
render cat --set reflectance=blurple | 'blurple' is no colour
render cat --set reflectance=2,0,0 | reflectance.r = 2
groom grow x.obj --skin 2,0,0 | [0, 1]
render cat --layers nope | unknown layer 'nope'
render cat --checkpoint -1s | 60s, 5m or 2h
render cat --strands 0 | above 0%
render cat --strands -5 | above 0%
scene nope | there is no scene 'nope'
scene raccoon -o x.txt | end in .usda
scene --small | NAME
groom info raccoon --frame 1 | the built-in scene raccoon has its own
groom convert raccoon -o x.png | end in .usda or .usdc or .abc or .hair
groom convert raccoon --frame 3 -o x.usda | the built-in scene raccoon has its own
groom grow ball.obj -o x.txt | end in .usda
groom grow ball.obj --segments 4000000000 --count 10 | '--segments <N>': it must be a whole number in [1, 65536]
groom grow ball.obj --segments 65536 --count 1000000000 | count = 1000000000
groom grow ball.obj --count -1 | whole number in [1, 4294967295]
groom grow ball.obj --density nan | density = NaN
groom grow ball.obj --density 0 | density = 0 is out of range: it must be above 0
groom grow ball.obj --comb nan,0,0 | finite
groom grow ball.obj --curl-turns inf | curl_turns = inf
groom grow x.usda --lift 91 | [-90, 90] degrees
groom grow x.usda --fiber nope | unknown preset 'nope'
groom grow x.usda --set eta=9 | in --set eta=9: eta = 9
groom grow x.usda --settings x.toml | cannot read x.toml
plot lobes --out x.gif | end in .png or .svg
plot medulla --out x.gif | end in .png or .svg
plot profile --fiber all --out x.gif | end in .png or .svg
plot error --fiber all --out x.gif | end in .png or .svg
plot lobes --theta-o nan | theta_o = NaN
plot lobes --h 2 | h = 2
plot medulla --photons 5 | whole number in [1000, 1000000000]
plot medulla --table /dev/zero | it is a device
plot profile --fiber all --set kappa=9 | in --set kappa=9
plot windows --window near | no width
table build --out . | folder
table build --out x.v --photons 5 | whole number in [1000, 1000000000]
table build --out x.v --seed -1 | whole number
table check --profiles 0 | whole number in [1, 1000000]
table check --photons 5 | whole number in [1000, 1000000000]
table info /dev/zero | it is a device
eval --out . | folder
eval --queries /dev/zero | it is a device
eval --set kappa=1 | in --set kappa=1: kappa = 1
eval --set sigma_ca=1,2 | not 2
eval --fiber x.toml | cannot read x.toml
energy --out . | folder
energy --theta-o nan | theta_o = NaN
reference --out . | folder
reference --photons 0 | whole number in [2, 1000000000000]
reference --photons -1 | whole number in [2, 1000000000000]
reference --h nan | h = NaN
merge x.film -o x.txt | end in .exr or .png
merge x.film --exposure nan | finite number in [-100, 100]
merge x.film | cannot read x.film
experiment nope | there is no experiment 'nope'
";

#[test]
fn bad_input_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for line in COMMANDS.lines().filter(|line| !line.is_empty()) {
        let (command, part) = line.split_once(" | ").unwrap();
        // `/dev/zero` does not exist on systems without devices.
        if cfg!(not(unix)) && command.contains("/dev/zero") {
            continue;
        }
        let start = Instant::now();
        let output = vellus(folder.path(), &command.split(' ').collect::<Vec<_>>());
        let (seconds, message) = (start.elapsed(), String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(2), "{command}: {message}");
        assert!(output.stdout.is_empty(), "{command}");
        assert!(message.starts_with("error: ") && message.contains(part), "{command}: '{part}' is not in: {message}");
        // clap adds the usage to its messages.
        assert!(message.lines().count() == 1 || message.contains("--help"), "{command}: {message}");
        assert!(seconds < LIMIT, "{command}: {seconds:?}");
    }
    let files = |entry: &std::fs::DirEntry| entry.path().is_file() && entry.file_name() != "ball.obj";
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(Result::unwrap).filter(files).collect();
    assert!(left.is_empty(), "{left:?}");
}
