//! Who may connect.

use crate::Error;
use axum::http::{HeaderMap, header};

/// The rules for requests.
#[derive(Clone, Debug)]
pub struct Guard {
    /// The first part of every path, if the server listens on more than the loopback address.
    pub token: Option<String>,
}

impl Guard {
    /// A guard with a random token of 128 bits if `guarded`.
    ///
    /// # Errors
    /// [`Error::System`] if the system gives no random numbers.
    pub fn new(guarded: bool) -> Result<Self, Error> {
        let mut bytes = [0; 16];
        if guarded {
            getrandom::fill(&mut bytes).map_err(|error| Error::System {
                what: "random numbers",
                source: std::io::Error::other(error.to_string()),
            })?;
        }
        Ok(Guard { token: guarded.then(|| bytes.iter().map(|byte| format!("{byte:02x}")).collect()) })
    }

    /// The path of a request without the token. `None` if the token is wrong or missing.
    pub fn path<'a>(&self, path: &'a str) -> Option<&'a str> {
        let Some(token) = &self.token else { return Some(path) };
        let rest = path.strip_prefix('/')?;
        let (given, rest) = rest.split_at_checked(token.len())?;
        // The time does not depend on the place of the first difference.
        let differences = given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        (differences == 0 && rest.starts_with('/')).then_some(rest)
    }

    /// Whether the headers are those of a page of this server.
    ///
    /// Without a token, the host must be a loopback name: a foreign page whose name resolves to this machine has its
    /// own name there. A request with an origin must have the origin of this server: browsers send the origin of the
    /// page with every WebSocket and every upload.
    pub fn allows(&self, headers: &HeaderMap) -> bool {
        let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
        let Some(host) = text(header::HOST) else { return false };
        if self.token.is_none() && !is_loopback(host) {
            return false;
        }
        text(header::ORIGIN).is_none_or(|origin| origin.strip_prefix("http://") == Some(host))
    }
}

/// Whether the host of an address, with or without a port, is this machine.
fn is_loopback(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split_once(']').map_or(rest, |(name, _)| name),
        None => host.split_once(':').map_or(host, |(name, _)| name),
    };
    name.eq_ignore_ascii_case("localhost") || name.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        origin.map(|origin| headers.insert(header::ORIGIN, origin.parse().unwrap()));
        headers
    }

    #[test]
    fn only_own_pages_may_connect() {
        let open = Guard::new(false).unwrap();
        for host in ["localhost:7878", "127.0.0.1:1", "[::1]:80", "localhost"] {
            assert!(open.allows(&headers(host, None)));
            assert!(open.allows(&headers(host, Some(&format!("http://{host}")))));
            assert!(!open.allows(&headers(host, Some("http://evil.example"))));
            assert!(!open.allows(&headers(host, Some("null"))));
        }
        for host in ["evil.example:7878", "127.0.0.1.evil.example", "192.168.0.2:7878", ""] {
            assert!(!open.allows(&headers(host, None)), "{host}");
        }
        assert!(!open.allows(&HeaderMap::new()));
    }

    #[test]
    fn every_path_needs_the_token() {
        let guard = Guard::new(true).unwrap();
        let token = guard.token.clone().unwrap();
        assert_eq!(token.len(), 32);
        assert_ne!(Guard::new(true).unwrap().token.unwrap(), token);
        assert_eq!(guard.path(&format!("/{token}/ws")), Some("/ws"));
        assert_eq!(guard.path(&format!("/{token}")), None);
        assert_eq!((guard.path("/"), guard.path("/ws"), guard.path(&format!("/x{token}/ws"))), (None, None, None));
        assert_eq!(guard.path("/ééééééééééééééééé/ws"), None);
    }
}
