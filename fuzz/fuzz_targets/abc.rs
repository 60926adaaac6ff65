#![no_main]
//! Alembic archives: the tree, and every schema at two times.

use vellus_alembic::*;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(archive) = Archive::open(bytes.to_vec()) else { return };
    for (i, object) in archive.objects.iter().enumerate() {
        let _ = archive.find(&archive.path(i));
        for time in [0.0, 1.5] {
            let _ = Curves::read(&archive, object, time);
            let _ = Mesh::read(&archive, object, time);
            let _ = Camera::read(&archive, object, time);
            let _ = Xform::read(&archive, object, time).map(|xform| xform.matrix());
            let _ = visibility(&archive, object, time);
            let _ = instance_source(&archive, object);
            for property in attributes(object).iter().chain(user_properties(object)) {
                let _ = Attribute::read(&archive, property, time).map(|found| found.number(found.rows(), 0));
            }
        }
    }
});
