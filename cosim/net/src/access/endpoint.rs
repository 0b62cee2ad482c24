//! Endpoints such as `tcp/127.0.0.1:7447`, and who can reach them.

use std::net::{IpAddr, ToSocketAddrs};

use cosim_base::error::{Code, Error, Result};

/// A protocol and an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Endpoint<'a> {
    /// A socket in the file system: the permissions of its folder decide who can reach it.
    Unix,
    /// Host and port, unencrypted.
    Tcp(&'a str, u16),
    /// Host and port with TLS.
    Tls(&'a str, u16),
}

impl<'a> Endpoint<'a> {
    /// Parses an endpoint.
    pub(crate) fn parse(text: &'a str) -> Result<Self> {
        let refused = |why: &str| {
            Error::new(Code::Session, format!("the endpoint {text} is refused")).why(why)
        };
        let Some((protocol, address)) = text.split_once('/') else {
            return Err(refused("an endpoint is a protocol and an address: tcp/127.0.0.1:7447"));
        };
        // They would override the settings for certificates.
        if address.contains(['#', '?']) {
            return Err(refused("settings after the address are not accepted")
                .help("put them into the file of --config"));
        }
        let host_and_port = || {
            let (host, port) = address.rsplit_once(':').ok_or("the port is missing")?;
            let port = port.parse().map_err(|_| "the port is not a number from 0 to 65535")?;
            match host.strip_prefix('[') {
                Some(inner) => inner.strip_suffix(']').ok_or("a bracket is missing"),
                None if host.contains(':') => Err("an IPv6 address needs brackets: [::1]:7447"),
                None => Ok(host),
            }
            .and_then(|host| if host.is_empty() { Err("the host is missing") } else { Ok(host) })
            .map(|host| (host, port))
        };
        match protocol {
            "unixsock-stream" => Ok(Self::Unix),
            "tcp" => host_and_port().map(|(host, port)| Self::Tcp(host, port)).map_err(refused),
            "tls" => host_and_port().map(|(host, port)| Self::Tls(host, port)).map_err(refused),
            _ => Err(refused("the protocols are tcp, tls and unixsock-stream")),
        }
    }

    /// Refuses endpoints that other machines could reach without TLS.
    pub(crate) fn permit(text: &'a str, insecure: bool) -> Result<Self> {
        let endpoint = Self::parse(text)?;
        match endpoint {
            Self::Tcp(host, _) if !insecure && !is_loopback(host) => {
                Err(Error::new(Code::Session, format!("the endpoint {text} is refused"))
                    .why("anyone who can reach it could load code into a worker")
                    .help("tls/HOST:PORT with --credentials FOLDER (cosim keys), or --insecure"))
            }
            _ => Ok(endpoint),
        }
    }
}

/// Whether only this machine can be meant. A name may resolve to something else a moment later, so
/// the only name accepted is `localhost`, and only while all its addresses are loopback.
fn is_loopback(host: &str) -> bool {
    match host.parse::<IpAddr>() {
        Ok(IpAddr::V4(ip)) => ip.is_loopback(),
        Ok(IpAddr::V6(ip)) => ip.is_loopback(),
        Err(_) if host.eq_ignore_ascii_case("localhost") => {
            let meant: Vec<IpAddr> =
                (host, 0).to_socket_addrs().into_iter().flatten().map(|a| a.ip()).collect();
            !meant.is_empty() && meant.iter().all(IpAddr::is_loopback)
        }
        Err(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};

    use proptest::prelude::*;

    use super::*;

    fn is_open(endpoint: &str) -> bool {
        let refusal = Endpoint::permit(endpoint, false).unwrap_err().to_string();
        assert!(refusal.contains("--insecure"), "{refusal}");
        assert!(Endpoint::permit(endpoint, true).is_ok(), "{endpoint}");
        true
    }

    #[test]
    fn only_this_machine_is_open_without_tls() {
        for own in [
            "tcp/127.0.0.1:7447",
            "tcp/127.255.255.254:1",
            "tcp/[::1]:7447",
            "tcp/localhost:7447",
            "tcp/LocalHost:7447",
            "unixsock-stream//run/x.sock",
            "tls/0.0.0.0:7447",
            "tls/example.org:7447",
        ] {
            assert!(Endpoint::permit(own, false).is_ok(), "{own}");
        }
        for open in [
            "tcp/0.0.0.0:7447",
            "tcp/[::]:7447",
            "tcp/[::ffff:127.0.0.1]:7447",
            "tcp/[::ffff:192.0.2.1]:7447",
            "tcp/192.0.2.1:7447",
            "tcp/localhost.example.org:7447",
            "tcp/127.0.0.1.example.org:7447",
            "tcp/2130706433:7447",
            "tcp/0x7f.1:7447",
            "tcp/*:7447",
        ] {
            assert!(is_open(open));
        }
    }

    #[test]
    fn what_is_no_endpoint_is_refused_whatever_is_waived() {
        for (text, why) in [
            ("127.0.0.1:7447", "a protocol and an address"),
            ("udp/127.0.0.1:7447", "the protocols are"),
            ("quic/127.0.0.1:7447", "the protocols are"),
            ("tcp/127.0.0.1", "port"),
            ("tcp/127.0.0.1:70000", "port"),
            ("tcp/::1:7447", "brackets"),
            ("tcp/[::1:7447", "bracket"),
            ("tcp/:7447", "host"),
            ("tls/example.org:7447#verify_name_on_connect=false", "--config"),
            ("tcp/127.0.0.1:7447?rel=0", "--config"),
        ] {
            let refusal = Endpoint::permit(text, true).unwrap_err().to_string();
            assert!(refusal.contains(why), "{text}: {refusal}");
        }
    }

    proptest! {
        #[test]
        fn an_ip4_address_is_own_exactly_in_127_8(octets: [u8; 4], port: u16) {
            let address = SocketAddr::from((Ipv4Addr::from(octets), port));
            let own = Endpoint::permit(&format!("tcp/{address}"), false).is_ok();
            prop_assert_eq!(own, octets[0] == 127);
        }

        #[test]
        fn an_ip6_address_is_own_only_as_one(bits: u128, port: u16) {
            let address = SocketAddr::from((Ipv6Addr::from_bits(bits), port));
            let own = Endpoint::permit(&format!("tcp/{address}"), false).is_ok();
            prop_assert_eq!(own, bits == 1);
        }

        #[test]
        fn a_name_is_never_own(name in "[a-z][a-z0-9.-]{0,20}", port: u16) {
            prop_assume!(name != "localhost");
            let endpoint = format!("tcp/{name}:{port}");
            prop_assert!(Endpoint::permit(&endpoint, false).is_err());
        }

        #[test]
        fn any_text_is_refused_or_understood(text in "\\PC{0,40}") {
            let _ = Endpoint::permit(&text, false);
        }
    }
}
