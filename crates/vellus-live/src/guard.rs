//! Who may connect.

use crate::Error;
use axum::http::{HeaderMap, HeaderName, header};

/// The rules for requests.
#[derive(Clone, Debug)]
pub struct Guard {
    /// The first part of every path, if the server listens on more than the loopback address.
    pub token: Option<String>,
    /// What requests for files must have in the header [`PAGE_TOKEN`]. The server tells it to its own page.
    pub page: String,
}

/// The header with the token of the page.
pub const PAGE_TOKEN: HeaderName = HeaderName::from_static("x-vellus-token");

/// Where a request comes from, as the browser says.
const SEC_FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

impl Guard {
    /// A guard with random tokens of 128 bits. All paths have one if `guarded`.
    ///
    /// # Errors
    /// [`Error::System`] if the system gives no random numbers.
    pub fn new(guarded: bool) -> Result<Self, Error> {
        Ok(Guard { token: guarded.then(random).transpose()?, page: random()? })
    }

    /// The path of a request without the token. `None` if the token is wrong or missing.
    pub fn path<'a>(&self, path: &'a str) -> Option<&'a str> {
        let Some(token) = &self.token else { return Some(path) };
        let rest = path.strip_prefix('/')?;
        let (given, rest) = rest.split_at_checked(token.len())?;
        (is_same(given, token) && rest.starts_with('/')).then_some(rest)
    }

    /// Whether the headers are those of a page of this server.
    ///
    /// Without a token, the host must be a loopback name: a foreign page whose name resolves to this machine has its
    /// own name there. A request with an origin must have the origin of this server: browsers send the origin of the
    /// page with every WebSocket and every POST. They send none with images and scripts of foreign pages, but they say
    /// that the request comes from another site.
    pub fn allows(&self, headers: &HeaderMap) -> bool {
        let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
        let Some(host) = text(header::HOST) else { return false };
        if self.token.is_none() && !is_loopback(host) {
            return false;
        }
        let is_own_site = text(SEC_FETCH_SITE).is_none_or(|site| ["same-origin", "none"].contains(&site));
        is_own_site && text(header::ORIGIN).is_none_or(|origin| origin.strip_prefix("http://") == Some(host))
    }

    /// Whether the headers have the token of the page.
    pub fn is_page(&self, headers: &HeaderMap) -> bool {
        headers.get(PAGE_TOKEN).and_then(|value| value.to_str().ok()).is_some_and(|given| is_same(given, &self.page))
    }
}

/// 128 random bits.
fn random() -> Result<String, Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)
        .map_err(|error| Error::System { what: "random numbers", source: std::io::Error::other(error.to_string()) })?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Whether texts are equal. The time does not depend on the place of the first difference.
fn is_same(given: &str, token: &str) -> bool {
    given.len() == token.len() && given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

/// Whether the host of an address, with or without a port, is this machine.
fn is_loopback(host: &str) -> bool {
    let (name, port) = match host.strip_prefix('[') {
        Some(rest) => rest.split_once(']').unwrap_or(("", "")),
        None => host.split_at(host.find(':').unwrap_or(host.len())),
    };
    let is_port = |port: &str| !port.is_empty() && port.bytes().all(|digit| digit.is_ascii_digit());
    (port.is_empty() || port.strip_prefix(':').is_some_and(is_port))
        && (name.eq_ignore_ascii_case("localhost") || name.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, more: &[(&'static str, &str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        headers.extend(more.iter().map(|(name, value)| (HeaderName::from_static(name), value.parse().unwrap())));
        headers
    }

    #[test]
    fn only_own_pages_may_connect() {
        let open = Guard::new(false).unwrap();
        for host in ["localhost:7878", "127.0.0.1:1", "[::1]:80", "[::1]", "localhost"] {
            assert!(open.allows(&headers(host, &[])));
            assert!(open.allows(&headers(host, &[("origin", &format!("http://{host}"))])));
            assert!(!open.allows(&headers(host, &[("origin", "http://evil.example")])));
            assert!(!open.allows(&headers(host, &[("origin", "null")])));
            for (site, allowed) in
                [("same-origin", true), ("none", true), ("same-site", false), ("cross-site", false), ("é", false)]
            {
                assert_eq!(open.allows(&headers(host, &[("sec-fetch-site", site)])), allowed, "{host} {site}");
            }
        }
        for host in [
            "evil.example:7878",
            "127.0.0.1.evil.example",
            "192.168.0.2:7878",
            "",
            "[::1].evil.example",
            "[::1]evil",
            "[::1",
            "localhost:80@evil.example",
            "localhost:",
            "localhost:80:80",
            "[::1]:",
        ] {
            assert!(!open.allows(&headers(host, &[])), "{host}");
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

    #[test]
    fn files_need_the_token_of_the_page() {
        let guard = Guard::new(true).unwrap();
        let with = |token: &str| guard.is_page(&headers("localhost", &[("x-vellus-token", token)]));
        assert!(with(&guard.page) && !with("") && !with(guard.token.as_ref().unwrap()) && !with(&guard.page[1..]));
        assert!(!guard.is_page(&HeaderMap::new()));
    }
}
