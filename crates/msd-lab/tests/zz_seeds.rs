//! temp
use msd_lab::msd_core::glam::DVec3;
use msd_lab::msd_core::{Friction, Interaction, Material, Pin, Plane, Scene, Settings, shape};
use msd_lab::recording::Event;
use msd_lab::{Loaded, Output, Precision, Recorder, Runner, load_recording, write_saved};
#[test]
fn seeds() {
    for precision in [Precision::F32, Precision::F64] {
        let material = Material { mass: 0.1, stiffness: 40.0, damping: 0.2 };
        let mut scene = Scene::of("rope", shape::rope(3, 0.3, material).unwrap());
        scene.planes.push(Plane {
            normal: DVec3::Y,
            offset: -0.2,
            restitution: 0.5,
            friction: Friction::Coulomb(0.5),
        });
        scene.pins.push(Pin { particle: 0, velocity: DVec3::ZERO });
        let mut runner =
            Runner::new(&scene, Settings { substeps: 2, ..Settings::default() }, precision)
                .unwrap();
        for _ in 0..20 {
            runner.step().unwrap();
        }
        let grab = Interaction::Grab {
            particle: 2,
            target: DVec3::new(0.5, 0.1, 0.2),
            frequency: 2.0,
            damping_ratio: 0.8,
            max_force: 50.0,
        };
        let start = Loaded::of("rope", "a rope", &runner);
        let folder = std::path::PathBuf::from("../../fuzz/corpus/runs");
        let path = folder.join(format!("recording-{}", precision.name()));
        let _ = std::fs::remove_file(&path);
        let mut recorder = Recorder::begin(&path, &start).unwrap();
        runner.queue(grab).unwrap();
        runner.apply_queued().unwrap();
        recorder.add(&Event::Act(grab)).unwrap();
        for _ in 0..3 {
            runner.step().unwrap();
            recorder.step().unwrap();
        }
        recorder.finish(&runner).unwrap();
        load_recording(&path).unwrap();
        let path = folder.join(format!("saved-{}", precision.name()));
        let _ = std::fs::remove_file(&path);
        write_saved(&Loaded::of("rope", "a rope", &runner), Output::create(&path).unwrap())
            .unwrap();
    }
}
