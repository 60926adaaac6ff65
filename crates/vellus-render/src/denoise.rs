//! Intel Open Image Denoise 2. It is loaded at run time if it is installed. It is neither compiled nor shipped with
//! this crate.
#![allow(unsafe_code, reason = "a C library")]

use crate::error::Error;
use crate::film::denoised::Denoise;
use crate::film::{Film, Layer};
use libloading::{Library, Symbol};
use std::ffi::{CStr, OsStr, c_char, c_void};
use std::path::PathBuf;
use std::process::Command;

type Result<T> = std::result::Result<T, Error>;

/// `OIDN_DEVICE_TYPE_CPU`, `OIDN_FORMAT_FLOAT3`.
const CPU: i32 = 1;
const FLOAT3: i32 = 3;

type Handle = *mut c_void;
type Make = unsafe extern "C" fn(i32) -> Handle;
type MakeFilter = unsafe extern "C" fn(Handle, *const c_char) -> Handle;
type Do = unsafe extern "C" fn(Handle);
type Share = unsafe extern "C" fn(Handle, *const c_char, *mut c_void, i32, usize, usize, usize, usize, usize);
type SetBool = unsafe extern "C" fn(Handle, *const c_char, bool);
type GetError = unsafe extern "C" fn(Handle, *mut *const c_char) -> i32;

/// The library, as the system knows it.
const NAME: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// The library in the package `pyoidn`, if the Python on the path has it.
fn in_python() -> Option<PathBuf> {
    // Not from the current folder, which Python would search first.
    let script = "import importlib.util as u, sys; sys.path.remove(''); \
                  print(u.find_spec('pyoidn').submodule_search_locations[0], end='')";
    let asked = ["python3", "python"].iter().find_map(|python| {
        let output = Command::new(python).args(["-c", script]).output().ok()?;
        output.status.success().then_some(output.stdout)
    })?;
    let folder = PathBuf::from(String::from_utf8(asked).ok()?).join("oidn");
    [folder.join("lib").join(NAME), folder.join("bin").join(NAME)].into_iter().find(|path| path.is_file())
}

/// An error of the library.
fn failed(what: &str) -> Error {
    Error::Denoise(what.to_owned())
}

/// The loaded library.
#[derive(Debug)]
pub struct Denoiser {
    /// The library is never unloaded, because its threads do not end.
    library: &'static Library,
}

impl Denoiser {
    /// Loads the library that the environment variable `VELLUS_OIDN` names. If it is not set, loads version 2 from the
    /// folders of the system, or from the package `pyoidn` of the Python on the path.
    ///
    /// # Errors
    /// [`Error::Denoise`] if there is no such library.
    pub fn load() -> Result<Self> {
        let path = std::env::var_os("VELLUS_OIDN").unwrap_or_else(|| NAME.into());
        // SAFETY: loading runs code of the library; it is the one that the user named or installed.
        let open = |path: &OsStr| unsafe { Library::new(path) };
        let library = match open(&path) {
            Err(e) if path == NAME => in_python().and_then(|path| open(path.as_os_str()).ok()).ok_or(e),
            other => other,
        };
        let library = library.map_err(|e| {
            let what = "denoising needs Intel Open Image Denoise 2: install it (for example with `pip install \
                        pyoidn`), or set VELLUS_OIDN to the path of";
            // The cause names the file and the reason.
            let cause = std::error::Error::source(&e).map_or_else(|| e.to_string(), ToString::to_string);
            Error::Denoise(format!("{what} {NAME}: {cause}"))
        })?;
        let denoiser = Denoiser { library: Box::leak(Box::new(library)) };
        // Version 1 has this function under another name.
        denoiser.find::<SetBool>(c"oidnSetFilterBool").map_err(|_| {
            let path = path.to_string_lossy();
            Error::Denoise(format!("{path} is not Intel Open Image Denoise 2: `pip install pyoidn` installs it"))
        })?;
        Ok(denoiser)
    }

    fn find<T>(&self, name: &CStr) -> Result<Symbol<'static, T>> {
        // SAFETY: the types are those of OpenImageDenoise/oidn.h, version 2.
        unsafe { self.library.get(name.to_bytes_with_nul()) }
            .map_err(|e| Error::Denoise(format!("not Intel Open Image Denoise 2: {e}")))
    }

    /// Runs the filter for ray-traced pictures.
    fn filter(&self, device: Handle, [w, h]: [usize; 2], images: &[(&CStr, &[f32])], guided: bool) -> Result<Vec<f32>> {
        let make: Symbol<MakeFilter> = self.find(c"oidnNewFilter")?;
        let share: Symbol<Share> = self.find(c"oidnSetSharedFilterImage")?;
        let set: Symbol<SetBool> = self.find(c"oidnSetFilterBool")?;
        let commit: Symbol<Do> = self.find(c"oidnCommitFilter")?;
        let execute: Symbol<Do> = self.find(c"oidnExecuteFilter")?;
        let release: Symbol<Do> = self.find(c"oidnReleaseFilter")?;
        let error: Symbol<GetError> = self.find(c"oidnGetDeviceError")?;
        assert!(images.iter().all(|(_, values)| values.len() == 3 * w * h), "three values a pixel");
        let mut output = vec![0f32; 3 * w * h];
        // SAFETY: all images have w × h pixels of three floats and outlive the filter, which only writes to the output.
        unsafe {
            let filter = make(device, c"RT".as_ptr());
            for (name, values) in images {
                share(filter, name.as_ptr(), values.as_ptr().cast_mut().cast(), FLOAT3, w, h, 0, 0, 0);
            }
            share(filter, c"output".as_ptr(), output.as_mut_ptr().cast(), FLOAT3, w, h, 0, 0, 0);
            set(filter, c"hdr".as_ptr(), images[0].0 == c"color");
            set(filter, c"cleanAux".as_ptr(), guided);
            commit(filter);
            execute(filter);
            release(filter);
            let mut message = std::ptr::null();
            if error(device, &mut message) != 0 {
                let text =
                    if message.is_null() { "unknown error".into() } else { CStr::from_ptr(message).to_string_lossy() };
                return Err(failed(&text));
            }
        }
        Ok(output)
    }
}

impl Denoise for Denoiser {
    /// Albedo and normal are denoised first, because they are noisy in fur, too.
    fn clean(&self, film: &Film, pictures: &[Vec<f32>]) -> Result<Vec<Vec<f32>>> {
        let size = [film.width(), film.height()];
        let make: Symbol<Make> = self.find(c"oidnNewDevice")?;
        let [commit, release] = [c"oidnCommitDevice", c"oidnReleaseDevice"].map(|name| self.find::<Do>(name));
        let (commit, release) = (commit?, release?);
        // SAFETY: the device is created here and released below, after its last use.
        let device = unsafe { make(CPU) };
        if device.is_null() {
            return Err(failed("it has no device"));
        }
        // SAFETY: as above.
        unsafe { commit(device) };
        let filter = |images: &[(&CStr, &[f32])], guided: bool| self.filter(device, size, images, guided);
        let guide = |name: &'static CStr, layer: Layer| {
            film.rgb(layer).map(|values| Ok::<_, Error>((name, filter(&[(name, &values)], false)?))).transpose()
        };
        let cleaned = (|| {
            let albedo = guide(c"albedo", Layer::Albedo)?;
            // Normals are only used together with albedo.
            let normal = if albedo.is_some() { guide(c"normal", Layer::Normal)? } else { None };
            let guides = albedo.iter().chain(&normal).map(|(name, values)| (*name, &values[..]));
            let guides: Vec<_> = guides.collect();
            let clean = |color: &Vec<f32>| {
                // A lobe that no fibre of the picture has.
                if color.iter().all(|x| *x == 0.0) {
                    return Ok(color.clone());
                }
                let images: Vec<_> = std::iter::once((c"color", &color[..])).chain(guides.iter().copied()).collect();
                filter(&images, images.len() > 1)
            };
            pictures.iter().map(clean).collect()
        })();
        // SAFETY: as above.
        unsafe { release(device) };
        cleaned
    }
}
