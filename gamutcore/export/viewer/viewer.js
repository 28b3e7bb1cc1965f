var oe=class extends Error{constructor(e){super(e.detail);this.problem=e}problem;name="ProblemError"},x0=document.documentElement.dataset.root??"",yo="";function Sd(i){yo=i}function Md(){return yo!==""}function bo(){return yo===""?{}:{"X-API-Key":yo}}function ji(i){return new URL(x0+i,location.href).href}var kc=new Map;function wd(i,t){let e=null;kc.set(i,()=>(e??=t().catch(n=>{throw e=null,n}),e))}async function _0(i){if(i.startsWith("/v1/jobs/"))return i;for(let t of i.match(/\b[0-9a-f]{64}\b/g)??[]){let e=await kc.get(t)?.();e!==void 0&&(i=i.replace(t,e))}return i}async function Ee(i,t={}){let e,n=kc.size===0?i:await _0(i),s={Accept:"application/json",...bo(),...t.headers};try{e=await fetch(ji(n),{...t,headers:s})}catch(r){throw t.signal?.aborted?r:new oe(zc("The service does not answer.",0))}if(!e.ok)throw await Ed(e);return e}async function Ed(i){return(i.headers.get("content-type")??"").startsWith("application/problem+json")?new oe(await i.json()):new oe(zc(`The answer has status ${i.status}.`,i.status))}function zc(i,t){return{title:"No answer",detail:i,code:"",status:t,where:null,remedy:"Try again."}}var y0=["srgb","display-p3","bt2020","adobe-rgb-1998"];function b0(i,t){let e=y0.flatMap(r=>t.find(({key:o})=>o===r)??[]),n=t.filter(r=>!e.includes(r)),s=({key:r})=>r.startsWith("aces");return[...e,...i,...n.filter(r=>!s(r)),...n.filter(s)]}async function Ad(i,t){let e=i===""?{}:{name:i},n=new URLSearchParams({limit:"50",...e,match:"similar"}),[s,r,o]=await Promise.all([Ee(`/v1/gamuts?${n}`,{signal:t}).then(f=>f.json()),bd(),i===""?bd():S0(i,t)]),a=new Set(r.map(f=>f.name)),l=s.gamuts.filter(f=>!a.has(f.name)).map(f=>({key:f.id,name:f.name,detail:`stored · ${f.options.space}`}));if(i==="")return b0(l,r);let c=({key:f,name:g})=>{let x=[f,g].map(Oc);return x.includes(Oc(i))?0:x.some(p=>p.startsWith(Oc(i)))?1:3},h=o.map(c),d=f=>Math.min(f===0?2:3,...h.slice(f).map(g=>Math.max(1,g)),h[f]);return[...o.map((f,g)=>[f,d(g)]),...l.map(f=>[f,c(f)])].sort((f,g)=>f[1]-g[1]).map(([f])=>f)}function Oc(i){return i.toLowerCase().replaceAll(/[^\p{L}\p{N}]/gu,"")}async function S0(i,t){let e=await Ee(`/v1/references?${new URLSearchParams({name:i})}`,{signal:t});return Td(await e.json())}function Td({references:i}){return i.map(({slug:t,name:e})=>({key:t,name:e,detail:`reference · ${t}`}))}var Bc=null;function bd(){return Bc??=Ee("/v1/references").then(i=>i.json()).then(Td).catch(i=>{throw Bc=null,i}),Bc}async function So(i,t,e,n={}){let[s,r=""]=i.split("?"),o=new URLSearchParams(r);for(let[h,d]of Object.entries(n))o.set(h,d);let a=`/v1/gamuts/${encodeURIComponent(s)}?${o}`,l=()=>Ee(a,{signal:e,headers:{Prefer:"respond-async"}}),c=await l();return c.status===202&&(await Rd((await c.json()).id,t,e),c=await l()),await c.json()}async function Mo(i,t,e,n){await i.slice(0,1).arrayBuffer().catch(()=>{throw new Error(`${i.name} cannot be read, or it changed. Choose it again.`)});let s=new FormData;s.append("file",i),s.append("options",JSON.stringify(t)),e("upload",0,"");let r=await M0("/v1/gamuts",s,a=>e("upload",a,""),n),o=await r.json();return r.status===202&&await Rd(o.id,e,n),o.id}function M0(i,t,e,n){n.throwIfAborted();let s=new XMLHttpRequest;s.open("POST",ji(i));let r={Accept:"application/json",Prefer:"respond-async",...bo()};for(let[o,a]of Object.entries(r))s.setRequestHeader(o,a);return s.upload.onprogress=({loaded:o,total:a})=>e(o/a),new Promise((o,a)=>{n.addEventListener("abort",()=>s.abort()),s.onabort=()=>a(n.reason),s.onerror=()=>a(new oe(zc("The service does not answer.",0))),s.onload=()=>{let l=s.getResponseHeader("content-type")??"",c=new Response(s.responseText,{status:s.status,headers:{"content-type":l}});c.ok?o(c):Ed(c).then(a)},s.send(t)})}async function ir(i=!1){try{let{state:t}=await(await Ee("/")).json(),e=t.probes.kernels,n=/compiling (\d+ of \d+ kernels)/.exec(e?.detail??"")?.[1]??"kernels";if(i&&t.ready&&e?.detail?.includes("optional: compiling"))return`Preparing answers: ${n} compiled, only once`;if(t.ready)return null;if(e?.status==="failed")return`Preparing the service: ${n} compiled, only once`;if(t.workers_warm<t.workers)return"Preparing the service: starting, a few seconds"}catch{}return null}async function Cd(i){await Ee(`/v1/jobs/${i}`,{method:"DELETE"})}async function Rd(i,t,e){let n="";for(;;){let s={Accept:"text/event-stream",...n===""?{}:{"Last-Event-ID":n}},r=await Ee(`/v1/jobs/${i}/events`,{signal:e,headers:s});for await(let o of w0(r)){n=o.id;let a=JSON.parse(o.data);if(a.problem!==null)throw new oe(a.problem);if(a.state==="succeeded")return;t(a.stage||"waiting",a.fraction,i)}if(r.status===204)return;await new Promise(o=>setTimeout(o,500))}}async function*w0(i){if(i.body===null)return;let t=i.body.pipeThrough(new TextDecoderStream).getReader(),e="";for(;;){let{done:n,value:s}=await t.read().catch(()=>({done:!0,value:void 0}));if(n)return;e+=s;let r=e.split(`

`);e=r.pop();for(let o of r){let a=c=>new RegExp(`^${c}: (.*)$`,"m").exec(o)?.[1],l=a("data");l!==void 0&&(yield{id:a("id")??"",data:l})}}}function L(i){return document.getElementById(i)}function sr(i){L(i).open=!0}function tt(i,t="",e={}){let n=document.createElement(i);return n.textContent=t,Object.assign(n,e)}function Zi(i,t){let e=tt("a","",{href:URL.createObjectURL(i),download:t});e.click(),setTimeout(()=>URL.revokeObjectURL(e.href),1e4)}function cs(i){if(!Array.isArray(i))return[];let t=i.map(e=>{let{message:n,detail:s}=e??{};return(typeof e=="string"?e:String(n??s??"")).replaceAll(/ \((?:--|")[^)]*\)/g,"")});return[...new Set(t)].filter(e=>e!=="")}var Pd={"invalid-option":"Choose another option, or another value.","unknown-reference":"Choose a reference from the list.","gamut-not-found":"Choose the file again: the same file with the same options gives the same gamut.","api-key-required":"Type a key of this service below.","invalid-parameter":"Choose the gamut from the list."};function Hc({code:i,remedy:t}){return i in Pd?Pd[i]:/Retry-After/.test(t)?"Try again in a moment.":/\b[Pp]ost\b/.test(t)?"Choose the file again.":/\/v1\/|\b(GET|POST|PUT|DELETE)\b/.test(t)?"Try again with another file or option.":t}function si(i,t=""){let e=l=>tt("strong",t===""?l:`${t}: ${l}`);if(!(i instanceof oe))return[e("Error"),tt("p",i instanceof Error?i.message:String(i))];let{title:n,detail:s,where:r}=i.problem,o=r?.line,a=typeof o=="number"?`Line ${o}: `:"";return[e(n),tt("p",a+s),tt("p",Hc(i.problem))]}var Id='<script type="application/json" id="page-state">';function E0(){let i=document.getElementById("gamut-file")?.textContent;if(i==null)return null;let{gamuts:t,coverage:e}=JSON.parse(i),n=document.getElementById("page-state")?.textContent??"null";return{gamuts:t.map(({gamut:s,history:r})=>({gamut:s,history:A0(r)})),coverage:e??null,state:JSON.parse(n)}}function Ld(i,t){let[e,n]=[i.slice(0,i.lastIndexOf(Id)),i.slice(i.lastIndexOf("<\/script>"))];return`${e}${Id}${JSON.stringify(t).replaceAll("<","\\u003c")}${n}`}function A0(i){let t=atob(i),e=new Uint8Array(t.length);for(let n=0;n<e.length;n++)e[n]=t.charCodeAt(n);return e}var qt=E0();function Dd(){let i=document.getElementById("worker-source");return i===null?new URL("worker.js",import.meta.url).href:URL.createObjectURL(new Blob([i.textContent??""],{type:"text/javascript"}))}var hs={triangles:"The surface of a gamut is made of flat triangles. More of them follow it more closely.","full boundary":"The surface with all triangles, before any were taken away.",δe00:"CIEDE2000: how different two colours look. One unit is about what an eye can just see.","rendering intent":"How the white of the paper or display is treated when colours are converted.","ink limit":"Largest sum of all inks that the press may print. Four full inks are 400 %.",volume:"The size of the solid in cubic units of its space. × sRGB divides it by that of sRGB in the same space.",channels:"Inks or lights of the device, in the order of its values.",projection:"Perspective makes near things larger. Orthographic keeps sizes, for measuring by eye.",where:"Inside, outside, or on the edge: so close to the surface that it may be either.",euclidean:"Euclidean distance from the surface in units of the space of the gamut; below 0 inside.",recipe:"Device values, such as amounts of ink, that give the colour.","recipe δe00":"CIEDE2000 between the wanted colour and the colour that the recipe gives.",possible:"Least and largest amount of black with which the device gives the colour."};function Nd(i){let t=i.toLowerCase();return hs[t]??hs[t.split(/[ ,]/)[0]]}function Gc(i,t=hs[i.toLowerCase()]){if(t===void 0)return tt("span",i);let e=tt("button",i,{type:"button",className:"term"});return e.dataset.note=t,e}function wo(i){let t=tt("dl");for(let[e,n,s]of i){let r=tt("dt");r.append(Gc(e,s)),t.append(r,tt("dd",n))}return t}function Eo(i){return i.split(/(ΔE00)/).map((t,e)=>e%2===1?Gc(t):t)}function Ud(){let i=L("term-note");for(let r of document.querySelectorAll("[data-term]")){let o=Gc(r.textContent,hs[r.dataset.term]);r instanceof HTMLLabelElement&&(o.id=`${r.htmlFor}-term`,L(r.htmlFor).setAttribute("aria-labelledby",o.id)),r.replaceWith(o)}let t=null,e=()=>{t?.removeAttribute("aria-describedby"),t=null,i.matches(":popover-open")&&i.hidePopover()},n=r=>{if(r===t)return;e(),t=r,i.textContent=r.dataset.note??"",r.setAttribute("aria-describedby",i.id),i.showPopover();let o=r.getBoundingClientRect(),{offsetWidth:a,offsetHeight:l}=i;i.style.left=`${Math.max(8,Math.min(o.left,innerWidth-a-8))}px`,i.style.top=`${o.bottom+l+8>innerHeight?o.top-l-4:o.bottom+4}px`},s=({target:r})=>r instanceof Element?r.closest("[data-note]"):null;for(let r of["pointerover","focusin","click"])addEventListener(r,o=>{if(o.target.isConnected===!1)return;let a=s(o);a!==null?n(a):(t!==document.activeElement||r==="click")&&e()});addEventListener("keydown",({key:r})=>r==="Escape"&&e()),addEventListener("scroll",e,!0)}var Bi={LEFT:0,MIDDLE:1,RIGHT:2,ROTATE:0,DOLLY:1,PAN:2},ki={ROTATE:0,PAN:1,DOLLY_PAN:2,DOLLY_ROTATE:3},_f=0,bh=1,yf=2;var kr=1,bf=2,zs=3,zn=0,Ae=1,en=2,is=0,Hs=1,Sh=2,Mh=3,wh=4,Sf=5;var ss=100,Mf=101,wf=102,Ef=103,Af=104,Tf=200,Cf=201,Rf=202,Pf=203,Eh=204,Ah=205,If=206,Lf=207,Df=208,Nf=209,Uf=210,Ff=211,Of=212,Bf=213,kf=214,ea=0,na=1,ia=2,Ts=3,Cs=4,sa=5,ra=6,oa=7,Th=0,zf=1,Hf=2,Zn=0,Ch=1,Rh=2,Ph=3,Ih=4,Lh=5,Dh=6,Nh=7;var Uh=300,rs=301,Gs=302,La=303,Da=304,aa=1e3,jn=1001,la=1002,Ue=1003,Gf=1004;var zr=1005;var Be=1006,Na=1007;var gi=1008;var vn=1009,Fh=1010,Oh=1011,Vs=1012,Ua=1013,Hn=1014,Gn=1015,xn=1016,Fa=1017,Oa=1018,os=1020,Bh=35902,kh=35899,zh=1021,Hh=1022,_n=1023,di=1026,vi=1027,Gh=1028,Ba=1029,zi=1030,ka=1031;var za=1033,Hr=33776,Gr=33777,Vr=33778,Wr=33779,Ha=35840,Ga=35841,Va=35842,Wa=35843,$a=36196,Xa=37492,qa=37496,Ya=37488,ja=37489,$r=37490,Za=37491,Ka=37808,Ja=37809,Qa=37810,tl=37811,el=37812,nl=37813,il=37814,sl=37815,rl=37816,ol=37817,al=37818,ll=37819,cl=37820,hl=37821,ul=36492,dl=36494,fl=36495,pl=36283,ml=36284,Xr=36285,gl=36286;var pr=2300,ca=2301,Qo=2302,hh=2303,uh=2400,dh=2401,fh=2402;var Vf=3200;var Vh=0,Wf=1,xi="",dn="srgb",mr="srgb-linear",gr="linear",Jt="srgb";var ta=7680,Wh=7681;var $h=34055,Xh=34056;var vl=517;var $f=519,Xf=512,qf=513,Yf=514,qh=515,jf=516,Zf=517,Yh=518,jh=519,Zh=35044;var Kh="300 es",Tn=2e3,vr=2001;function T0(i){for(let t=i.length-1;t>=0;--t)if(i[t]>=65535)return!0;return!1}function C0(i){return ArrayBuffer.isView(i)&&!(i instanceof DataView)}function xr(i){return document.createElementNS("http://www.w3.org/1999/xhtml",i)}function Kf(){let i=xr("canvas");return i.style.display="block",i}var Fd={},Rs=null;function _r(...i){let t="THREE."+i.shift();Rs?Rs("log",t,...i):console.log(t,...i)}function Jf(i){let t=i[0];if(typeof t=="string"&&t.startsWith("TSL:")){let e=i[1];e&&e.isStackTrace?i[0]+=" "+e.getLocation():i[1]='Stack trace not available. Enable "THREE.Node.captureStackTrace" to capture stack traces.'}return i}function Tt(...i){i=Jf(i);let t="THREE."+i.shift();if(Rs)Rs("warn",t,...i);else{let e=i[0];e&&e.isStackTrace?console.warn(e.getError(t)):console.warn(t,...i)}}function Lt(...i){i=Jf(i);let t="THREE."+i.shift();if(Rs)Rs("error",t,...i);else{let e=i[0];e&&e.isStackTrace?console.error(e.getError(t)):console.error(t,...i)}}function ur(...i){let t=i.join(" ");t in Fd||(Fd[t]=!0,Tt(...i))}function Qf(i,t,e){return new Promise(function(n,s){function r(){switch(i.clientWaitSync(t,i.SYNC_FLUSH_COMMANDS_BIT,0)){case i.WAIT_FAILED:s();break;case i.TIMEOUT_EXPIRED:setTimeout(r,e);break;default:n()}}setTimeout(r,e)})}var tp={[ea]:ea,[ia]:ra,[Cs]:Cs,[Ts]:sa,[na]:na,[ra]:ia,[oa]:oa,[sa]:Ts},On=class{addEventListener(t,e){this._listeners===void 0&&(this._listeners={});let n=this._listeners;n[t]===void 0&&(n[t]=[]),n[t].indexOf(e)===-1&&n[t].push(e)}hasEventListener(t,e){let n=this._listeners;return n===void 0?!1:n[t]!==void 0&&n[t].indexOf(e)!==-1}removeEventListener(t,e){let n=this._listeners;if(n===void 0)return;let s=n[t];if(s!==void 0){let r=s.indexOf(e);r!==-1&&s.splice(r,1)}}dispatchEvent(t){let e=this._listeners;if(e===void 0)return;let n=e[t.type];if(n!==void 0){t.target=this;let s=n.slice(0);for(let r=0,o=s.length;r<o;r++)s[r].call(this,t);t.target=null}}},We=["00","01","02","03","04","05","06","07","08","09","0a","0b","0c","0d","0e","0f","10","11","12","13","14","15","16","17","18","19","1a","1b","1c","1d","1e","1f","20","21","22","23","24","25","26","27","28","29","2a","2b","2c","2d","2e","2f","30","31","32","33","34","35","36","37","38","39","3a","3b","3c","3d","3e","3f","40","41","42","43","44","45","46","47","48","49","4a","4b","4c","4d","4e","4f","50","51","52","53","54","55","56","57","58","59","5a","5b","5c","5d","5e","5f","60","61","62","63","64","65","66","67","68","69","6a","6b","6c","6d","6e","6f","70","71","72","73","74","75","76","77","78","79","7a","7b","7c","7d","7e","7f","80","81","82","83","84","85","86","87","88","89","8a","8b","8c","8d","8e","8f","90","91","92","93","94","95","96","97","98","99","9a","9b","9c","9d","9e","9f","a0","a1","a2","a3","a4","a5","a6","a7","a8","a9","aa","ab","ac","ad","ae","af","b0","b1","b2","b3","b4","b5","b6","b7","b8","b9","ba","bb","bc","bd","be","bf","c0","c1","c2","c3","c4","c5","c6","c7","c8","c9","ca","cb","cc","cd","ce","cf","d0","d1","d2","d3","d4","d5","d6","d7","d8","d9","da","db","dc","dd","de","df","e0","e1","e2","e3","e4","e5","e6","e7","e8","e9","ea","eb","ec","ed","ee","ef","f0","f1","f2","f3","f4","f5","f6","f7","f8","f9","fa","fb","fc","fd","fe","ff"],Od=1234567,dr=Math.PI/180,Ps=180/Math.PI;function Hi(){let i=Math.random()*4294967295|0,t=Math.random()*4294967295|0,e=Math.random()*4294967295|0,n=Math.random()*4294967295|0;return(We[i&255]+We[i>>8&255]+We[i>>16&255]+We[i>>24&255]+"-"+We[t&255]+We[t>>8&255]+"-"+We[t>>16&15|64]+We[t>>24&255]+"-"+We[e&63|128]+We[e>>8&255]+"-"+We[e>>16&255]+We[e>>24&255]+We[n&255]+We[n>>8&255]+We[n>>16&255]+We[n>>24&255]).toLowerCase()}function Ft(i,t,e){return Math.max(t,Math.min(e,i))}function Jh(i,t){return(i%t+t)%t}function R0(i,t,e,n,s){return n+(i-t)*(s-n)/(e-t)}function P0(i,t,e){return i!==t?(e-i)/(t-i):0}function fr(i,t,e){return(1-e)*i+e*t}function I0(i,t,e,n){return fr(i,t,1-Math.exp(-e*n))}function L0(i,t=1){return t-Math.abs(Jh(i,t*2)-t)}function D0(i,t,e){return i<=t?0:i>=e?1:(i=(i-t)/(e-t),i*i*(3-2*i))}function N0(i,t,e){return i<=t?0:i>=e?1:(i=(i-t)/(e-t),i*i*i*(i*(i*6-15)+10))}function U0(i,t){return i+Math.floor(Math.random()*(t-i+1))}function F0(i,t){return i+Math.random()*(t-i)}function O0(i){return i*(.5-Math.random())}function B0(i){i!==void 0&&(Od=i);let t=Od+=1831565813;return t=Math.imul(t^t>>>15,t|1),t^=t+Math.imul(t^t>>>7,t|61),((t^t>>>14)>>>0)/4294967296}function k0(i){return i*dr}function z0(i){return i*Ps}function H0(i){return i>0&&Number.isInteger(i)&&2**Math.round(Math.log2(i))===i}function G0(i){return Math.pow(2,Math.ceil(Math.log(i)/Math.LN2))}function Qh(i){return Math.pow(2,Math.floor(Math.log(i)/Math.LN2))}function V0(i,t,e,n,s){let r=Math.cos,o=Math.sin,a=r(e/2),l=o(e/2),c=r((t+n)/2),h=o((t+n)/2),d=r((t-n)/2),u=o((t-n)/2),f=r((n-t)/2),g=o((n-t)/2);switch(s){case"XYX":i.set(a*h,l*d,l*u,a*c);break;case"YZY":i.set(l*u,a*h,l*d,a*c);break;case"ZXZ":i.set(l*d,l*u,a*h,a*c);break;case"XZX":i.set(a*h,l*g,l*f,a*c);break;case"YXY":i.set(l*f,a*h,l*g,a*c);break;case"ZYZ":i.set(l*g,l*f,a*h,a*c);break;default:Tt("MathUtils: .setQuaternionFromProperEuler() encountered an unknown order: "+s)}}function xl(i){switch(i.constructor){case Uint32Array:return 4294967295;case Uint16Array:return 65535;case Uint8Array:case Uint8ClampedArray:return 255;case Int32Array:return 2147483647;case Int16Array:return 32767;case Int8Array:return 127;default:return}}function tu(i,t){if(t.constructor===Float32Array)return i;let e=xl(t);if(e===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.max(i/e,-1)}function eu(i,t){if(t.constructor===Float32Array)return i;let e=xl(t);if(e===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.round(i*e)}var _i={DEG2RAD:dr,RAD2DEG:Ps,generateUUID:Hi,clamp:Ft,euclideanModulo:Jh,mapLinear:R0,inverseLerp:P0,lerp:fr,damp:I0,pingpong:L0,smoothstep:D0,smootherstep:N0,randInt:U0,randFloat:F0,randFloatSpread:O0,seededRandom:B0,degToRad:k0,radToDeg:z0,isPowerOfTwo:H0,ceilPowerOfTwo:G0,floorPowerOfTwo:Qh,setQuaternionFromProperEuler:V0,normalize:eu,denormalize:tu},Ct=class{static{this.prototype.isVector2=!0}constructor(t=0,e=0){this.x=t,this.y=e}get width(){return this.x}set width(t){this.x=t}get height(){return this.y}set height(t){this.y=t}set(t,e){return this.x=t,this.y=e,this}setScalar(t){return this.x=t,this.y=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;default:throw new Error("THREE.Vector2: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;default:throw new Error("THREE.Vector2: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y)}copy(t){return this.x=t.x,this.y=t.y,this}add(t){return this.x+=t.x,this.y+=t.y,this}addScalar(t){return this.x+=t,this.y+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this}subScalar(t){return this.x-=t,this.y-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this}multiply(t){return this.x*=t.x,this.y*=t.y,this}multiplyScalar(t){return this.x*=t,this.y*=t,this}divide(t){return this.x/=t.x,this.y/=t.y,this}divideScalar(t){return this.multiplyScalar(1/t)}applyMatrix3(t){let e=this.x,n=this.y,s=t.elements;return this.x=s[0]*e+s[3]*n+s[6],this.y=s[1]*e+s[4]*n+s[7],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this}clamp(t,e){return this.x=Ft(this.x,t.x,e.x),this.y=Ft(this.y,t.y,e.y),this}clampScalar(t,e){return this.x=Ft(this.x,t,e),this.y=Ft(this.y,t,e),this}clampLength(t,e){let n=this.length();return this.divideScalar(n||1).multiplyScalar(Ft(n,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this}negate(){return this.x=-this.x,this.y=-this.y,this}dot(t){return this.x*t.x+this.y*t.y}cross(t){return this.x*t.y-this.y*t.x}lengthSq(){return this.x*this.x+this.y*this.y}length(){return Math.sqrt(this.x*this.x+this.y*this.y)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)}normalize(){return this.divideScalar(this.length()||1)}angle(){return Math.atan2(-this.y,-this.x)+Math.PI}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let n=this.dot(t)/e;return Math.acos(Ft(n,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,n=this.y-t.y;return e*e+n*n}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this}lerpVectors(t,e,n){return this.x=t.x+(e.x-t.x)*n,this.y=t.y+(e.y-t.y)*n,this}equals(t){return t.x===this.x&&t.y===this.y}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this}rotateAround(t,e){let n=Math.cos(e),s=Math.sin(e),r=this.x-t.x,o=this.y-t.y;return this.x=r*n-o*s+t.x,this.y=r*s+o*n+t.y,this}random(){return this.x=Math.random(),this.y=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y}},fn=class{constructor(t=0,e=0,n=0,s=1){this.isQuaternion=!0,this._x=t,this._y=e,this._z=n,this._w=s}static slerpFlat(t,e,n,s,r,o,a){let l=n[s+0],c=n[s+1],h=n[s+2],d=n[s+3],u=r[o+0],f=r[o+1],g=r[o+2],x=r[o+3];if(d!==x||l!==u||c!==f||h!==g){let p=l*u+c*f+h*g+d*x;p<0&&(u=-u,f=-f,g=-g,x=-x,p=-p);let m=1-a;if(p<.9995){let _=Math.acos(p),M=Math.sin(_);m=Math.sin(m*_)/M,a=Math.sin(a*_)/M,l=l*m+u*a,c=c*m+f*a,h=h*m+g*a,d=d*m+x*a}else{l=l*m+u*a,c=c*m+f*a,h=h*m+g*a,d=d*m+x*a;let _=1/Math.sqrt(l*l+c*c+h*h+d*d);l*=_,c*=_,h*=_,d*=_}}t[e]=l,t[e+1]=c,t[e+2]=h,t[e+3]=d}static multiplyQuaternionsFlat(t,e,n,s,r,o){let a=n[s],l=n[s+1],c=n[s+2],h=n[s+3],d=r[o],u=r[o+1],f=r[o+2],g=r[o+3];return t[e]=a*g+h*d+l*f-c*u,t[e+1]=l*g+h*u+c*d-a*f,t[e+2]=c*g+h*f+a*u-l*d,t[e+3]=h*g-a*d-l*u-c*f,t}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get w(){return this._w}set w(t){this._w=t,this._onChangeCallback()}set(t,e,n,s){return this._x=t,this._y=e,this._z=n,this._w=s,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._w)}copy(t){return this._x=t.x,this._y=t.y,this._z=t.z,this._w=t.w,this._onChangeCallback(),this}setFromEuler(t,e=!0){let n=t._x,s=t._y,r=t._z,o=t._order,a=Math.cos,l=Math.sin,c=a(n/2),h=a(s/2),d=a(r/2),u=l(n/2),f=l(s/2),g=l(r/2);switch(o){case"XYZ":this._x=u*h*d+c*f*g,this._y=c*f*d-u*h*g,this._z=c*h*g+u*f*d,this._w=c*h*d-u*f*g;break;case"YXZ":this._x=u*h*d+c*f*g,this._y=c*f*d-u*h*g,this._z=c*h*g-u*f*d,this._w=c*h*d+u*f*g;break;case"ZXY":this._x=u*h*d-c*f*g,this._y=c*f*d+u*h*g,this._z=c*h*g+u*f*d,this._w=c*h*d-u*f*g;break;case"ZYX":this._x=u*h*d-c*f*g,this._y=c*f*d+u*h*g,this._z=c*h*g-u*f*d,this._w=c*h*d+u*f*g;break;case"YZX":this._x=u*h*d+c*f*g,this._y=c*f*d+u*h*g,this._z=c*h*g-u*f*d,this._w=c*h*d-u*f*g;break;case"XZY":this._x=u*h*d-c*f*g,this._y=c*f*d-u*h*g,this._z=c*h*g+u*f*d,this._w=c*h*d+u*f*g;break;default:Tt("Quaternion: .setFromEuler() encountered an unknown order: "+o)}return e===!0&&this._onChangeCallback(),this}setFromAxisAngle(t,e){let n=e/2,s=Math.sin(n);return this._x=t.x*s,this._y=t.y*s,this._z=t.z*s,this._w=Math.cos(n),this._onChangeCallback(),this}setFromRotationMatrix(t){let e=t.elements,n=e[0],s=e[4],r=e[8],o=e[1],a=e[5],l=e[9],c=e[2],h=e[6],d=e[10],u=n+a+d;if(u>0){let f=.5/Math.sqrt(u+1);this._w=.25/f,this._x=(h-l)*f,this._y=(r-c)*f,this._z=(o-s)*f}else if(n>a&&n>d){let f=2*Math.sqrt(1+n-a-d);this._w=(h-l)/f,this._x=.25*f,this._y=(s+o)/f,this._z=(r+c)/f}else if(a>d){let f=2*Math.sqrt(1+a-n-d);this._w=(r-c)/f,this._x=(s+o)/f,this._y=.25*f,this._z=(l+h)/f}else{let f=2*Math.sqrt(1+d-n-a);this._w=(o-s)/f,this._x=(r+c)/f,this._y=(l+h)/f,this._z=.25*f}return this._onChangeCallback(),this}setFromUnitVectors(t,e){let n=t.dot(e)+1;return n<1e-8?(n=0,Math.abs(t.x)>Math.abs(t.z)?(this._x=-t.y,this._y=t.x,this._z=0,this._w=n):(this._x=0,this._y=-t.z,this._z=t.y,this._w=n)):(this._x=t.y*e.z-t.z*e.y,this._y=t.z*e.x-t.x*e.z,this._z=t.x*e.y-t.y*e.x,this._w=n),this.normalize()}angleTo(t){return 2*Math.acos(Math.abs(Ft(this.dot(t),-1,1)))}rotateTowards(t,e){let n=this.angleTo(t);if(n===0)return this;let s=Math.min(1,e/n);return this.slerp(t,s),this}identity(){return this.set(0,0,0,1)}invert(){return this.conjugate()}conjugate(){return this._x*=-1,this._y*=-1,this._z*=-1,this._onChangeCallback(),this}dot(t){return this._x*t._x+this._y*t._y+this._z*t._z+this._w*t._w}lengthSq(){return this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w}length(){return Math.sqrt(this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w)}normalize(){let t=this.length();return t===0?(this._x=0,this._y=0,this._z=0,this._w=1):(t=1/t,this._x=this._x*t,this._y=this._y*t,this._z=this._z*t,this._w=this._w*t),this._onChangeCallback(),this}multiply(t){return this.multiplyQuaternions(this,t)}premultiply(t){return this.multiplyQuaternions(t,this)}multiplyQuaternions(t,e){let n=t._x,s=t._y,r=t._z,o=t._w,a=e._x,l=e._y,c=e._z,h=e._w;return this._x=n*h+o*a+s*c-r*l,this._y=s*h+o*l+r*a-n*c,this._z=r*h+o*c+n*l-s*a,this._w=o*h-n*a-s*l-r*c,this._onChangeCallback(),this}slerp(t,e){let n=t._x,s=t._y,r=t._z,o=t._w,a=this.dot(t);a<0&&(n=-n,s=-s,r=-r,o=-o,a=-a);let l=1-e;if(a<.9995){let c=Math.acos(a),h=Math.sin(c);l=Math.sin(l*c)/h,e=Math.sin(e*c)/h,this._x=this._x*l+n*e,this._y=this._y*l+s*e,this._z=this._z*l+r*e,this._w=this._w*l+o*e,this._onChangeCallback()}else this._x=this._x*l+n*e,this._y=this._y*l+s*e,this._z=this._z*l+r*e,this._w=this._w*l+o*e,this.normalize();return this}slerpQuaternions(t,e,n){return this.copy(t).slerp(e,n)}random(){let t=2*Math.PI*Math.random(),e=2*Math.PI*Math.random(),n=Math.random(),s=Math.sqrt(1-n),r=Math.sqrt(n);return this.set(s*Math.sin(t),s*Math.cos(t),r*Math.sin(e),r*Math.cos(e))}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._w===this._w}fromArray(t,e=0){return this._x=t[e],this._y=t[e+1],this._z=t[e+2],this._w=t[e+3],this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._w,t}fromBufferAttribute(t,e){return this._x=t.getX(e),this._y=t.getY(e),this._z=t.getZ(e),this._w=t.getW(e),this._onChangeCallback(),this}toJSON(){return this.toArray()}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._w}},P=class{static{this.prototype.isVector3=!0}constructor(t=0,e=0,n=0){this.x=t,this.y=e,this.z=n}set(t,e,n){return n===void 0&&(n=this.z),this.x=t,this.y=e,this.z=n,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;default:throw new Error("THREE.Vector3: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;default:throw new Error("THREE.Vector3: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this}multiplyVectors(t,e){return this.x=t.x*e.x,this.y=t.y*e.y,this.z=t.z*e.z,this}applyEuler(t){return this.applyQuaternion(Bd.setFromEuler(t))}applyAxisAngle(t,e){return this.applyQuaternion(Bd.setFromAxisAngle(t,e))}applyMatrix3(t){let e=this.x,n=this.y,s=this.z,r=t.elements;return this.x=r[0]*e+r[3]*n+r[6]*s,this.y=r[1]*e+r[4]*n+r[7]*s,this.z=r[2]*e+r[5]*n+r[8]*s,this}applyNormalMatrix(t){return this.applyMatrix3(t).normalize()}applyMatrix4(t){let e=this.x,n=this.y,s=this.z,r=t.elements,o=1/(r[3]*e+r[7]*n+r[11]*s+r[15]);return this.x=(r[0]*e+r[4]*n+r[8]*s+r[12])*o,this.y=(r[1]*e+r[5]*n+r[9]*s+r[13])*o,this.z=(r[2]*e+r[6]*n+r[10]*s+r[14])*o,this}applyQuaternion(t){let e=this.x,n=this.y,s=this.z,r=t.x,o=t.y,a=t.z,l=t.w,c=2*(o*s-a*n),h=2*(a*e-r*s),d=2*(r*n-o*e);return this.x=e+l*c+o*d-a*h,this.y=n+l*h+a*c-r*d,this.z=s+l*d+r*h-o*c,this}project(t){return this.applyMatrix4(t.matrixWorldInverse).applyMatrix4(t.projectionMatrix)}unproject(t){return this.applyMatrix4(t.projectionMatrixInverse).applyMatrix4(t.matrixWorld)}transformDirection(t){let e=this.x,n=this.y,s=this.z,r=t.elements;return this.x=r[0]*e+r[4]*n+r[8]*s,this.y=r[1]*e+r[5]*n+r[9]*s,this.z=r[2]*e+r[6]*n+r[10]*s,this.normalize()}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this}divideScalar(t){return this.multiplyScalar(1/t)}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this}clamp(t,e){return this.x=Ft(this.x,t.x,e.x),this.y=Ft(this.y,t.y,e.y),this.z=Ft(this.z,t.z,e.z),this}clampScalar(t,e){return this.x=Ft(this.x,t,e),this.y=Ft(this.y,t,e),this.z=Ft(this.z,t,e),this}clampLength(t,e){let n=this.length();return this.divideScalar(n||1).multiplyScalar(Ft(n,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this}lerpVectors(t,e,n){return this.x=t.x+(e.x-t.x)*n,this.y=t.y+(e.y-t.y)*n,this.z=t.z+(e.z-t.z)*n,this}cross(t){return this.crossVectors(this,t)}crossVectors(t,e){let n=t.x,s=t.y,r=t.z,o=e.x,a=e.y,l=e.z;return this.x=s*l-r*a,this.y=r*o-n*l,this.z=n*a-s*o,this}projectOnVector(t){let e=t.lengthSq();if(e===0)return this.set(0,0,0);let n=t.dot(this)/e;return this.copy(t).multiplyScalar(n)}projectOnPlane(t){return Vc.copy(this).projectOnVector(t),this.sub(Vc)}reflect(t){return this.sub(Vc.copy(t).multiplyScalar(2*this.dot(t)))}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let n=this.dot(t)/e;return Math.acos(Ft(n,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,n=this.y-t.y,s=this.z-t.z;return e*e+n*n+s*s}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)+Math.abs(this.z-t.z)}setFromSpherical(t){return this.setFromSphericalCoords(t.radius,t.phi,t.theta)}setFromSphericalCoords(t,e,n){let s=Math.sin(e)*t;return this.x=s*Math.sin(n),this.y=Math.cos(e)*t,this.z=s*Math.cos(n),this}setFromCylindrical(t){return this.setFromCylindricalCoords(t.radius,t.theta,t.y)}setFromCylindricalCoords(t,e,n){return this.x=t*Math.sin(e),this.y=n,this.z=t*Math.cos(e),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this}setFromMatrixScale(t){let e=this.setFromMatrixColumn(t,0).length(),n=this.setFromMatrixColumn(t,1).length(),s=this.setFromMatrixColumn(t,2).length();return this.x=e,this.y=n,this.z=s,this}setFromMatrixColumn(t,e){return this.fromArray(t.elements,e*4)}setFromMatrix3Column(t,e){return this.fromArray(t.elements,e*3)}setFromEuler(t){return this.x=t._x,this.y=t._y,this.z=t._z,this}setFromColor(t){return this.x=t.r,this.y=t.g,this.z=t.b,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this}randomDirection(){let t=Math.random()*Math.PI*2,e=Math.random()*2-1,n=Math.sqrt(1-e*e);return this.x=n*Math.cos(t),this.y=e,this.z=n*Math.sin(t),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z}},Vc=new P,Bd=new fn,Nt=class{static{this.prototype.isMatrix3=!0}constructor(t,e,n,s,r,o,a,l,c){this.elements=[1,0,0,0,1,0,0,0,1],t!==void 0&&this.set(t,e,n,s,r,o,a,l,c)}set(t,e,n,s,r,o,a,l,c){let h=this.elements;return h[0]=t,h[1]=s,h[2]=a,h[3]=e,h[4]=r,h[5]=l,h[6]=n,h[7]=o,h[8]=c,this}identity(){return this.set(1,0,0,0,1,0,0,0,1),this}copy(t){let e=this.elements,n=t.elements;return e[0]=n[0],e[1]=n[1],e[2]=n[2],e[3]=n[3],e[4]=n[4],e[5]=n[5],e[6]=n[6],e[7]=n[7],e[8]=n[8],this}extractBasis(t,e,n){return t.setFromMatrix3Column(this,0),e.setFromMatrix3Column(this,1),n.setFromMatrix3Column(this,2),this}setFromMatrix4(t){let e=t.elements;return this.set(e[0],e[4],e[8],e[1],e[5],e[9],e[2],e[6],e[10]),this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let n=t.elements,s=e.elements,r=this.elements,o=n[0],a=n[3],l=n[6],c=n[1],h=n[4],d=n[7],u=n[2],f=n[5],g=n[8],x=s[0],p=s[3],m=s[6],_=s[1],M=s[4],y=s[7],T=s[2],E=s[5],v=s[8];return r[0]=o*x+a*_+l*T,r[3]=o*p+a*M+l*E,r[6]=o*m+a*y+l*v,r[1]=c*x+h*_+d*T,r[4]=c*p+h*M+d*E,r[7]=c*m+h*y+d*v,r[2]=u*x+f*_+g*T,r[5]=u*p+f*M+g*E,r[8]=u*m+f*y+g*v,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[3]*=t,e[6]*=t,e[1]*=t,e[4]*=t,e[7]*=t,e[2]*=t,e[5]*=t,e[8]*=t,this}determinant(){let t=this.elements,e=t[0],n=t[1],s=t[2],r=t[3],o=t[4],a=t[5],l=t[6],c=t[7],h=t[8];return e*o*h-e*a*c-n*r*h+n*a*l+s*r*c-s*o*l}invert(){let t=this.elements,e=t[0],n=t[1],s=t[2],r=t[3],o=t[4],a=t[5],l=t[6],c=t[7],h=t[8],d=h*o-a*c,u=a*l-h*r,f=c*r-o*l,g=e*d+n*u+s*f;if(g===0)return this.set(0,0,0,0,0,0,0,0,0);let x=1/g;return t[0]=d*x,t[1]=(s*c-h*n)*x,t[2]=(a*n-s*o)*x,t[3]=u*x,t[4]=(h*e-s*l)*x,t[5]=(s*r-a*e)*x,t[6]=f*x,t[7]=(n*l-c*e)*x,t[8]=(o*e-n*r)*x,this}transpose(){let t,e=this.elements;return t=e[1],e[1]=e[3],e[3]=t,t=e[2],e[2]=e[6],e[6]=t,t=e[5],e[5]=e[7],e[7]=t,this}getNormalMatrix(t){return this.setFromMatrix4(t).invert().transpose()}transposeIntoArray(t){let e=this.elements;return t[0]=e[0],t[1]=e[3],t[2]=e[6],t[3]=e[1],t[4]=e[4],t[5]=e[7],t[6]=e[2],t[7]=e[5],t[8]=e[8],this}setUvTransform(t,e,n,s,r,o,a){let l=Math.cos(r),c=Math.sin(r);return this.set(n*l,n*c,-n*(l*o+c*a)+o+t,-s*c,s*l,-s*(-c*o+l*a)+a+e,0,0,1),this}scale(t,e){return ur("Matrix3: .scale() is deprecated. Use .makeScale() instead."),this.premultiply(Wc.makeScale(t,e)),this}rotate(t){return ur("Matrix3: .rotate() is deprecated. Use .makeRotation() instead."),this.premultiply(Wc.makeRotation(-t)),this}translate(t,e){return ur("Matrix3: .translate() is deprecated. Use .makeTranslation() instead."),this.premultiply(Wc.makeTranslation(t,e)),this}makeTranslation(t,e){return t.isVector2?this.set(1,0,t.x,0,1,t.y,0,0,1):this.set(1,0,t,0,1,e,0,0,1),this}makeRotation(t){let e=Math.cos(t),n=Math.sin(t);return this.set(e,-n,0,n,e,0,0,0,1),this}makeScale(t,e){return this.set(t,0,0,0,e,0,0,0,1),this}equals(t){let e=this.elements,n=t.elements;for(let s=0;s<9;s++)if(e[s]!==n[s])return!1;return!0}fromArray(t,e=0){for(let n=0;n<9;n++)this.elements[n]=t[n+e];return this}toArray(t=[],e=0){let n=this.elements;return t[e]=n[0],t[e+1]=n[1],t[e+2]=n[2],t[e+3]=n[3],t[e+4]=n[4],t[e+5]=n[5],t[e+6]=n[6],t[e+7]=n[7],t[e+8]=n[8],t}clone(){return new this.constructor().fromArray(this.elements)}},Wc=new Nt,kd=new Nt().set(.4123908,.3575843,.1804808,.212639,.7151687,.0721923,.0193308,.1191948,.9505322),zd=new Nt().set(3.2409699,-1.5373832,-.4986108,-.9692436,1.8759675,.0415551,.0556301,-.203977,1.0569715);function W0(){let i={enabled:!0,workingColorSpace:mr,spaces:{},convert:function(s,r,o){return this.enabled===!1||r===o||!r||!o||(this.spaces[r].transfer===Jt&&(s.r=ui(s.r),s.g=ui(s.g),s.b=ui(s.b)),this.spaces[r].primaries!==this.spaces[o].primaries&&(s.applyMatrix3(this.spaces[r].toXYZ),s.applyMatrix3(this.spaces[o].fromXYZ)),this.spaces[o].transfer===Jt&&(s.r=As(s.r),s.g=As(s.g),s.b=As(s.b))),s},workingToColorSpace:function(s,r){return this.convert(s,this.workingColorSpace,r)},colorSpaceToWorking:function(s,r){return this.convert(s,r,this.workingColorSpace)},getPrimaries:function(s){return this.spaces[s].primaries},getTransfer:function(s){return s===xi?gr:this.spaces[s].transfer},getToneMappingMode:function(s){return this.spaces[s].outputColorSpaceConfig.toneMappingMode||"standard"},getLuminanceCoefficients:function(s,r=this.workingColorSpace){return s.fromArray(this.spaces[r].luminanceCoefficients)},define:function(s){Object.assign(this.spaces,s)},_getMatrix:function(s,r,o){return s.copy(this.spaces[o].fromXYZ).multiply(this.spaces[r].toXYZ)},_getDrawingBufferColorSpace:function(s){return this.spaces[s].outputColorSpaceConfig.drawingBufferColorSpace},_getUnpackColorSpace:function(s=this.workingColorSpace){return this.spaces[s].workingColorSpaceConfig.unpackColorSpace}},t=[.64,.33,.3,.6,.15,.06],e=[.2126,.7152,.0722],n=[.3127,.329];return i.define({[mr]:{primaries:t,whitePoint:n,transfer:gr,toXYZ:kd,fromXYZ:zd,luminanceCoefficients:e,workingColorSpaceConfig:{unpackColorSpace:dn},outputColorSpaceConfig:{drawingBufferColorSpace:dn}},[dn]:{primaries:t,whitePoint:n,transfer:Jt,toXYZ:kd,fromXYZ:zd,luminanceCoefficients:e,outputColorSpaceConfig:{drawingBufferColorSpace:dn}}}),i}var Xt=W0();function ui(i){return i<.04045?i*.0773993808:Math.pow(i*.9478672986+.0521327014,2.4)}function As(i){return i<.0031308?i*12.92:1.055*Math.pow(i,.41666)-.055}var us,ha=class{static getDataURL(t,e="image/png"){if(/^data:/i.test(t.src)||typeof HTMLCanvasElement>"u")return t.src;let n;if(t instanceof HTMLCanvasElement)n=t;else{us===void 0&&(us=xr("canvas")),us.width=t.width,us.height=t.height;let s=us.getContext("2d");t instanceof ImageData?s.putImageData(t,0,0):s.drawImage(t,0,0,t.width,t.height),n=us}return n.toDataURL(e)}static sRGBToLinear(t){if(typeof HTMLImageElement<"u"&&t instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&t instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&t instanceof ImageBitmap){let e=xr("canvas");e.width=t.width,e.height=t.height;let n=e.getContext("2d");n.drawImage(t,0,0,t.width,t.height);let s=n.getImageData(0,0,t.width,t.height),r=s.data;for(let o=0;o<r.length;o++)r[o]=ui(r[o]/255)*255;return n.putImageData(s,0,0),e}else if(t.data){let e=t.data.slice(0);for(let n=0;n<e.length;n++)e instanceof Uint8Array||e instanceof Uint8ClampedArray?e[n]=Math.floor(ui(e[n]/255)*255):e[n]=ui(e[n]);return{data:e,width:t.width,height:t.height}}else return Tt("ImageUtils.sRGBToLinear(): Unsupported image type. No color space conversion applied."),t}},$0=0,Is=class{constructor(t=null){this.isTextureSource=!0,Object.defineProperty(this,"id",{value:$0++}),this.uuid=Hi(),this.data=t,this.dataReady=!0,this.version=0}getSize(t){let e=this.data;return typeof HTMLVideoElement<"u"&&e instanceof HTMLVideoElement?t.set(e.videoWidth,e.videoHeight,0):typeof VideoFrame<"u"&&e instanceof VideoFrame?t.set(e.displayWidth,e.displayHeight,0):e!==null?t.set(e.width||0,e.height||0,e.depth||0):t.set(0,0,0),t}set needsUpdate(t){t===!0&&this.version++}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.images[this.uuid]!==void 0)return t.images[this.uuid];let n={uuid:this.uuid,url:""},s=this.data;if(s!==null){let r;if(Array.isArray(s)){r=[];for(let o=0,a=s.length;o<a;o++)s[o].isDataTexture?r.push($c(s[o].image)):r.push($c(s[o]))}else r=$c(s);n.url=r}return e||(t.images[this.uuid]=n),n}};function $c(i){return typeof HTMLImageElement<"u"&&i instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&i instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&i instanceof ImageBitmap?ha.getDataURL(i):i.data?{data:Array.from(i.data),width:i.width,height:i.height,type:i.data.constructor.name}:(Tt("Texture: Unable to serialize Texture."),{})}var X0=0,Xc=new P,on=class i extends On{constructor(t=i.DEFAULT_IMAGE,e=i.DEFAULT_MAPPING,n=jn,s=jn,r=Be,o=gi,a=_n,l=vn,c=i.DEFAULT_ANISOTROPY,h=xi){super(),this.isTexture=!0,Object.defineProperty(this,"id",{value:X0++}),this.uuid=Hi(),this.name="",this.source=new Is(t),this.mipmaps=[],this.mapping=e,this.channel=0,this.wrapS=n,this.wrapT=s,this.magFilter=r,this.minFilter=o,this.anisotropy=c,this.format=a,this.internalFormat=null,this.type=l,this.offset=new Ct(0,0),this.repeat=new Ct(1,1),this.center=new Ct(0,0),this.rotation=0,this.matrixAutoUpdate=!0,this.matrix=new Nt,this.generateMipmaps=!0,this.mipmapsAutoUpdate=!0,this.premultiplyAlpha=!1,this.flipY=!0,this.unpackAlignment=4,this.colorSpace=h,this.userData={},this.updateRanges=[],this.version=0,this.onUpdate=null,this.renderTarget=null,this.isRenderTargetTexture=!1,this.isArrayTexture=!!(t&&t.depth&&t.depth>1),this.pmremVersion=0,this.isPMREMTexture=!1,this.normalized=!1}get width(){return this.source.getSize(Xc).x}get height(){return this.source.getSize(Xc).y}get depth(){return this.source.getSize(Xc).z}get image(){return this.source.data}set image(t){this.source.data=t}updateMatrix(){this.matrix.setUvTransform(this.offset.x,this.offset.y,this.repeat.x,this.repeat.y,this.rotation,this.center.x,this.center.y)}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}clone(){return new this.constructor().copy(this)}copy(t){return this.name=t.name,this.source=t.source,this.mipmaps=t.mipmaps.slice(0),this.mapping=t.mapping,this.channel=t.channel,this.wrapS=t.wrapS,this.wrapT=t.wrapT,this.magFilter=t.magFilter,this.minFilter=t.minFilter,this.anisotropy=t.anisotropy,this.format=t.format,this.internalFormat=t.internalFormat,this.type=t.type,this.normalized=t.normalized,this.offset.copy(t.offset),this.repeat.copy(t.repeat),this.center.copy(t.center),this.rotation=t.rotation,this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrix.copy(t.matrix),this.generateMipmaps=t.generateMipmaps,this.mipmapsAutoUpdate=t.mipmapsAutoUpdate,this.premultiplyAlpha=t.premultiplyAlpha,this.flipY=t.flipY,this.unpackAlignment=t.unpackAlignment,this.colorSpace=t.colorSpace,this.renderTarget=t.renderTarget,this.isRenderTargetTexture=t.isRenderTargetTexture,this.isPMREMTexture=t.isPMREMTexture,this.isArrayTexture=t.isArrayTexture,this.userData=JSON.parse(JSON.stringify(t.userData)),this.needsUpdate=!0,this}setValues(t){for(let e in t){let n=t[e];if(n===void 0){Tt(`Texture.setValues(): parameter '${e}' has value of undefined.`);continue}let s=this[e];if(s===void 0){Tt(`Texture.setValues(): property '${e}' does not exist.`);continue}s&&n&&s.isVector2&&n.isVector2||s&&n&&s.isVector3&&n.isVector3||s&&n&&s.isMatrix3&&n.isMatrix3?s.copy(n):this[e]=n}}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.textures[this.uuid]!==void 0)return t.textures[this.uuid];let n={metadata:{version:4.7,type:"Texture",generator:"Texture.toJSON"},uuid:this.uuid,name:this.name,image:this.source.toJSON(t).uuid,mapping:this.mapping,channel:this.channel,repeat:[this.repeat.x,this.repeat.y],offset:[this.offset.x,this.offset.y],center:[this.center.x,this.center.y],rotation:this.rotation,wrap:[this.wrapS,this.wrapT],format:this.format,internalFormat:this.internalFormat,type:this.type,normalized:this.normalized,colorSpace:this.colorSpace,minFilter:this.minFilter,magFilter:this.magFilter,anisotropy:this.anisotropy,flipY:this.flipY,generateMipmaps:this.generateMipmaps,mipmapsAutoUpdate:this.mipmapsAutoUpdate,premultiplyAlpha:this.premultiplyAlpha,unpackAlignment:this.unpackAlignment};return Object.keys(this.userData).length>0&&(n.userData=this.userData),e||(t.textures[this.uuid]=n),n}dispose(){this.dispatchEvent({type:"dispose"})}transformUv(t){if(this.mapping!==Uh)return t;if(t.applyMatrix3(this.matrix),t.x<0||t.x>1)switch(this.wrapS){case aa:t.x=t.x-Math.floor(t.x);break;case jn:t.x=t.x<0?0:1;break;case la:Math.abs(Math.floor(t.x)%2)===1?t.x=Math.ceil(t.x)-t.x:t.x=t.x-Math.floor(t.x);break}if(t.y<0||t.y>1)switch(this.wrapT){case aa:t.y=t.y-Math.floor(t.y);break;case jn:t.y=t.y<0?0:1;break;case la:Math.abs(Math.floor(t.y)%2)===1?t.y=Math.ceil(t.y)-t.y:t.y=t.y-Math.floor(t.y);break}return this.flipY&&(t.y=1-t.y),t}set needsUpdate(t){t===!0&&(this.version++,this.source.needsUpdate=!0)}set needsPMREMUpdate(t){t===!0&&this.pmremVersion++}};on.DEFAULT_IMAGE=null;on.DEFAULT_MAPPING=Uh;on.DEFAULT_ANISOTROPY=1;var ne=class{static{this.prototype.isVector4=!0}constructor(t=0,e=0,n=0,s=1){this.x=t,this.y=e,this.z=n,this.w=s}get width(){return this.z}set width(t){this.z=t}get height(){return this.w}set height(t){this.w=t}set(t,e,n,s){return this.x=t,this.y=e,this.z=n,this.w=s,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this.w=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setW(t){return this.w=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;case 3:this.w=e;break;default:throw new Error("THREE.Vector4: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;case 3:return this.w;default:throw new Error("THREE.Vector4: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z,this.w)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this.w=t.w!==void 0?t.w:1,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this.w+=t.w,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this.w+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this.w=t.w+e.w,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this.w+=t.w*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this.w-=t.w,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this.w-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this.w=t.w-e.w,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this.w*=t.w,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this.w*=t,this}applyMatrix4(t){let e=this.x,n=this.y,s=this.z,r=this.w,o=t.elements;return this.x=o[0]*e+o[4]*n+o[8]*s+o[12]*r,this.y=o[1]*e+o[5]*n+o[9]*s+o[13]*r,this.z=o[2]*e+o[6]*n+o[10]*s+o[14]*r,this.w=o[3]*e+o[7]*n+o[11]*s+o[15]*r,this}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this.w/=t.w,this}divideScalar(t){return this.multiplyScalar(1/t)}setAxisAngleFromQuaternion(t){this.w=2*Math.acos(t.w);let e=Math.sqrt(1-t.w*t.w);return e<1e-4?(this.x=1,this.y=0,this.z=0):(this.x=t.x/e,this.y=t.y/e,this.z=t.z/e),this}setAxisAngleFromRotationMatrix(t){let e,n,s,r,l=t.elements,c=l[0],h=l[4],d=l[8],u=l[1],f=l[5],g=l[9],x=l[2],p=l[6],m=l[10];if(Math.abs(h-u)<.01&&Math.abs(d-x)<.01&&Math.abs(g-p)<.01){if(Math.abs(h+u)<.1&&Math.abs(d+x)<.1&&Math.abs(g+p)<.1&&Math.abs(c+f+m-3)<.1)return this.set(1,0,0,0),this;e=Math.PI;let M=(c+1)/2,y=(f+1)/2,T=(m+1)/2,E=(h+u)/4,v=(d+x)/4,w=(g+p)/4;return M>y&&M>T?M<.01?(n=0,s=.707106781,r=.707106781):(n=Math.sqrt(M),s=E/n,r=v/n):y>T?y<.01?(n=.707106781,s=0,r=.707106781):(s=Math.sqrt(y),n=E/s,r=w/s):T<.01?(n=.707106781,s=.707106781,r=0):(r=Math.sqrt(T),n=v/r,s=w/r),this.set(n,s,r,e),this}let _=Math.sqrt((p-g)*(p-g)+(d-x)*(d-x)+(u-h)*(u-h));return Math.abs(_)<.001&&(_=1),this.x=(p-g)/_,this.y=(d-x)/_,this.z=(u-h)/_,this.w=Math.acos((c+f+m-1)/2),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this.w=e[15],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this.w=Math.min(this.w,t.w),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this.w=Math.max(this.w,t.w),this}clamp(t,e){return this.x=Ft(this.x,t.x,e.x),this.y=Ft(this.y,t.y,e.y),this.z=Ft(this.z,t.z,e.z),this.w=Ft(this.w,t.w,e.w),this}clampScalar(t,e){return this.x=Ft(this.x,t,e),this.y=Ft(this.y,t,e),this.z=Ft(this.z,t,e),this.w=Ft(this.w,t,e),this}clampLength(t,e){let n=this.length();return this.divideScalar(n||1).multiplyScalar(Ft(n,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this.w=Math.floor(this.w),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this.w=Math.ceil(this.w),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this.w=Math.round(this.w),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this.w=Math.trunc(this.w),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this.w=-this.w,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z+this.w*t.w}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)+Math.abs(this.w)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this.w+=(t.w-this.w)*e,this}lerpVectors(t,e,n){return this.x=t.x+(e.x-t.x)*n,this.y=t.y+(e.y-t.y)*n,this.z=t.z+(e.z-t.z)*n,this.w=t.w+(e.w-t.w)*n,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z&&t.w===this.w}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this.w=t[e+3],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t[e+3]=this.w,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this.w=t.getW(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this.w=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z,yield this.w}},ua=class extends On{constructor(t=1,e=1,n={}){super(),n=Object.assign({generateMipmaps:!1,internalFormat:null,minFilter:Be,depthBuffer:!0,stencilBuffer:!1,resolveColorBuffer:!0,resolveDepthBuffer:!0,resolveStencilBuffer:!0,storeMultisampledColorBuffer:!0,storeMultisampledDepthBuffer:!0,storeMultisampledStencilBuffer:!0,depthTexture:null,samples:0,count:1,depth:1,multiview:!1,useArrayDepthTexture:!1},n),this.isRenderTarget=!0,this.width=t,this.height=e,this.depth=n.depth,this.scissor=new ne(0,0,t,e),this.scissorTest=!1,this.viewport=new ne(0,0,t,e),this.textures=[];let s=n.count;for(let r=0;r<s;r++)this.textures[r]=new on({width:t,height:e,depth:n.depth}),this.textures[r].isRenderTargetTexture=!0,this.textures[r].renderTarget=this;this._setTextureOptions(n),this.depthBuffer=n.depthBuffer,this.stencilBuffer=n.stencilBuffer,this.resolveColorBuffer=n.resolveColorBuffer,this.resolveDepthBuffer=n.resolveDepthBuffer,this.resolveStencilBuffer=n.resolveStencilBuffer,this.storeMultisampledColorBuffer=n.storeMultisampledColorBuffer,this.storeMultisampledDepthBuffer=n.storeMultisampledDepthBuffer,this.storeMultisampledStencilBuffer=n.storeMultisampledStencilBuffer,this._depthTexture=null,this.depthTexture=n.depthTexture,this.samples=n.samples,this.multiview=n.multiview,this.useArrayDepthTexture=n.useArrayDepthTexture}_setTextureOptions(t={}){let e={minFilter:Be,generateMipmaps:!1,flipY:!1,internalFormat:null};t.mapping!==void 0&&(e.mapping=t.mapping),t.wrapS!==void 0&&(e.wrapS=t.wrapS),t.wrapT!==void 0&&(e.wrapT=t.wrapT),t.wrapR!==void 0&&(e.wrapR=t.wrapR),t.magFilter!==void 0&&(e.magFilter=t.magFilter),t.minFilter!==void 0&&(e.minFilter=t.minFilter),t.format!==void 0&&(e.format=t.format),t.type!==void 0&&(e.type=t.type),t.anisotropy!==void 0&&(e.anisotropy=t.anisotropy),t.colorSpace!==void 0&&(e.colorSpace=t.colorSpace),t.flipY!==void 0&&(e.flipY=t.flipY),t.generateMipmaps!==void 0&&(e.generateMipmaps=t.generateMipmaps),t.mipmapsAutoUpdate!==void 0&&(e.mipmapsAutoUpdate=t.mipmapsAutoUpdate),t.internalFormat!==void 0&&(e.internalFormat=t.internalFormat);for(let n=0;n<this.textures.length;n++)this.textures[n].setValues(e)}get texture(){return this.textures[0]}set texture(t){this.textures[0]=t}set depthTexture(t){this._depthTexture!==null&&this._depthTexture.renderTarget===this&&(this._depthTexture.renderTarget=null),t!==null&&t.renderTarget===null&&(t.renderTarget=this),this._depthTexture=t}get depthTexture(){return this._depthTexture}setSize(t,e,n=1){if(this.width!==t||this.height!==e||this.depth!==n){this.width=t,this.height=e,this.depth=n;for(let s=0,r=this.textures.length;s<r;s++)this.textures[s].image.width=t,this.textures[s].image.height=e,this.textures[s].image.depth=n,this.textures[s].isData3DTexture!==!0&&(this.textures[s].isArrayTexture=this.textures[s].image.depth>1);this.dispose()}this.viewport.set(0,0,t,e),this.scissor.set(0,0,t,e)}clone(){return new this.constructor().copy(this)}copy(t){this.width=t.width,this.height=t.height,this.depth=t.depth,this.scissor.copy(t.scissor),this.scissorTest=t.scissorTest,this.viewport.copy(t.viewport),this.textures.length=0;for(let e=0,n=t.textures.length;e<n;e++){this.textures[e]=t.textures[e].clone(),this.textures[e].isRenderTargetTexture=!0,this.textures[e].renderTarget=this;let s=Object.assign({},t.textures[e].image);this.textures[e].source=new Is(s)}if(this.depthBuffer=t.depthBuffer,this.stencilBuffer=t.stencilBuffer,this.resolveColorBuffer=t.resolveColorBuffer,this.resolveDepthBuffer=t.resolveDepthBuffer,this.resolveStencilBuffer=t.resolveStencilBuffer,this.storeMultisampledColorBuffer=t.storeMultisampledColorBuffer,this.storeMultisampledDepthBuffer=t.storeMultisampledDepthBuffer,this.storeMultisampledStencilBuffer=t.storeMultisampledStencilBuffer,t.depthTexture!==null)if(t.depthTexture.renderTarget===t){let e=t.depthTexture.clone();e.renderTarget=null,this.depthTexture=e}else this.depthTexture=t.depthTexture;else this.depthTexture=null;return this.samples=t.samples,this.multiview=t.multiview,this.useArrayDepthTexture=t.useArrayDepthTexture,this}dispose(){this.dispatchEvent({type:"dispose"})}},pn=class extends ua{constructor(t=1,e=1,n={}){super(t,e,n),this.isWebGLRenderTarget=!0}},yr=class extends on{constructor(t=null,e=1,n=1,s=1){super(null),this.isDataArrayTexture=!0,this.image={data:t,width:e,height:n,depth:s},this.magFilter=Ue,this.minFilter=Ue,this.wrapR=jn,this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1,this.layerUpdates=new Set}copy(t){return super.copy(t),this.wrapR=t.wrapR,this}addLayerUpdate(t){this.layerUpdates.add(t)}clearLayerUpdates(){this.layerUpdates.clear()}};var da=class extends on{constructor(t=null,e=1,n=1,s=1){super(null),this.isData3DTexture=!0,this.image={data:t,width:e,height:n,depth:s},this.magFilter=Ue,this.minFilter=Ue,this.wrapR=jn,this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1}copy(t){return super.copy(t),this.wrapR=t.wrapR,this}};var jt=class i{static{this.prototype.isMatrix4=!0}constructor(t,e,n,s,r,o,a,l,c,h,d,u,f,g,x,p){this.elements=[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],t!==void 0&&this.set(t,e,n,s,r,o,a,l,c,h,d,u,f,g,x,p)}set(t,e,n,s,r,o,a,l,c,h,d,u,f,g,x,p){let m=this.elements;return m[0]=t,m[4]=e,m[8]=n,m[12]=s,m[1]=r,m[5]=o,m[9]=a,m[13]=l,m[2]=c,m[6]=h,m[10]=d,m[14]=u,m[3]=f,m[7]=g,m[11]=x,m[15]=p,this}identity(){return this.set(1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1),this}clone(){return new i().fromArray(this.elements)}copy(t){let e=this.elements,n=t.elements;return e[0]=n[0],e[1]=n[1],e[2]=n[2],e[3]=n[3],e[4]=n[4],e[5]=n[5],e[6]=n[6],e[7]=n[7],e[8]=n[8],e[9]=n[9],e[10]=n[10],e[11]=n[11],e[12]=n[12],e[13]=n[13],e[14]=n[14],e[15]=n[15],this}copyPosition(t){let e=this.elements,n=t.elements;return e[12]=n[12],e[13]=n[13],e[14]=n[14],this}setFromMatrix3(t){let e=t.elements;return this.set(e[0],e[3],e[6],0,e[1],e[4],e[7],0,e[2],e[5],e[8],0,0,0,0,1),this}extractBasis(t,e,n){return this.determinantAffine()===0?(t.set(1,0,0),e.set(0,1,0),n.set(0,0,1),this):(t.setFromMatrixColumn(this,0),e.setFromMatrixColumn(this,1),n.setFromMatrixColumn(this,2),this)}makeBasis(t,e,n){return this.set(t.x,e.x,n.x,0,t.y,e.y,n.y,0,t.z,e.z,n.z,0,0,0,0,1),this}extractRotation(t){if(t.determinantAffine()===0)return this.identity();let e=this.elements,n=t.elements,s=1/ds.setFromMatrixColumn(t,0).length(),r=1/ds.setFromMatrixColumn(t,1).length(),o=1/ds.setFromMatrixColumn(t,2).length();return e[0]=n[0]*s,e[1]=n[1]*s,e[2]=n[2]*s,e[3]=0,e[4]=n[4]*r,e[5]=n[5]*r,e[6]=n[6]*r,e[7]=0,e[8]=n[8]*o,e[9]=n[9]*o,e[10]=n[10]*o,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromEuler(t){let e=this.elements,n=t.x,s=t.y,r=t.z,o=Math.cos(n),a=Math.sin(n),l=Math.cos(s),c=Math.sin(s),h=Math.cos(r),d=Math.sin(r);if(t.order==="XYZ"){let u=o*h,f=o*d,g=a*h,x=a*d;e[0]=l*h,e[4]=-l*d,e[8]=c,e[1]=f+g*c,e[5]=u-x*c,e[9]=-a*l,e[2]=x-u*c,e[6]=g+f*c,e[10]=o*l}else if(t.order==="YXZ"){let u=l*h,f=l*d,g=c*h,x=c*d;e[0]=u+x*a,e[4]=g*a-f,e[8]=o*c,e[1]=o*d,e[5]=o*h,e[9]=-a,e[2]=f*a-g,e[6]=x+u*a,e[10]=o*l}else if(t.order==="ZXY"){let u=l*h,f=l*d,g=c*h,x=c*d;e[0]=u-x*a,e[4]=-o*d,e[8]=g+f*a,e[1]=f+g*a,e[5]=o*h,e[9]=x-u*a,e[2]=-o*c,e[6]=a,e[10]=o*l}else if(t.order==="ZYX"){let u=o*h,f=o*d,g=a*h,x=a*d;e[0]=l*h,e[4]=g*c-f,e[8]=u*c+x,e[1]=l*d,e[5]=x*c+u,e[9]=f*c-g,e[2]=-c,e[6]=a*l,e[10]=o*l}else if(t.order==="YZX"){let u=o*l,f=o*c,g=a*l,x=a*c;e[0]=l*h,e[4]=x-u*d,e[8]=g*d+f,e[1]=d,e[5]=o*h,e[9]=-a*h,e[2]=-c*h,e[6]=f*d+g,e[10]=u-x*d}else if(t.order==="XZY"){let u=o*l,f=o*c,g=a*l,x=a*c;e[0]=l*h,e[4]=-d,e[8]=c*h,e[1]=u*d+x,e[5]=o*h,e[9]=f*d-g,e[2]=g*d-f,e[6]=a*h,e[10]=x*d+u}return e[3]=0,e[7]=0,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromQuaternion(t){return this.compose(q0,t,Y0)}lookAt(t,e,n){let s=this.elements;return hn.subVectors(t,e),hn.lengthSq()===0&&(hn.z=1),hn.normalize(),Ti.crossVectors(n,hn),Ti.lengthSq()===0&&(Math.abs(n.z)===1?hn.x+=1e-4:hn.z+=1e-4,hn.normalize(),Ti.crossVectors(n,hn)),Ti.normalize(),Ao.crossVectors(hn,Ti),s[0]=Ti.x,s[4]=Ao.x,s[8]=hn.x,s[1]=Ti.y,s[5]=Ao.y,s[9]=hn.y,s[2]=Ti.z,s[6]=Ao.z,s[10]=hn.z,this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let n=t.elements,s=e.elements,r=this.elements,o=n[0],a=n[4],l=n[8],c=n[12],h=n[1],d=n[5],u=n[9],f=n[13],g=n[2],x=n[6],p=n[10],m=n[14],_=n[3],M=n[7],y=n[11],T=n[15],E=s[0],v=s[4],w=s[8],F=s[12],D=s[1],N=s[5],O=s[9],V=s[13],C=s[2],H=s[6],X=s[10],G=s[14],nt=s[3],$=s[7],Q=s[11],et=s[15];return r[0]=o*E+a*D+l*C+c*nt,r[4]=o*v+a*N+l*H+c*$,r[8]=o*w+a*O+l*X+c*Q,r[12]=o*F+a*V+l*G+c*et,r[1]=h*E+d*D+u*C+f*nt,r[5]=h*v+d*N+u*H+f*$,r[9]=h*w+d*O+u*X+f*Q,r[13]=h*F+d*V+u*G+f*et,r[2]=g*E+x*D+p*C+m*nt,r[6]=g*v+x*N+p*H+m*$,r[10]=g*w+x*O+p*X+m*Q,r[14]=g*F+x*V+p*G+m*et,r[3]=_*E+M*D+y*C+T*nt,r[7]=_*v+M*N+y*H+T*$,r[11]=_*w+M*O+y*X+T*Q,r[15]=_*F+M*V+y*G+T*et,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[4]*=t,e[8]*=t,e[12]*=t,e[1]*=t,e[5]*=t,e[9]*=t,e[13]*=t,e[2]*=t,e[6]*=t,e[10]*=t,e[14]*=t,e[3]*=t,e[7]*=t,e[11]*=t,e[15]*=t,this}determinant(){let t=this.elements,e=t[0],n=t[4],s=t[8],r=t[12],o=t[1],a=t[5],l=t[9],c=t[13],h=t[2],d=t[6],u=t[10],f=t[14],g=t[3],x=t[7],p=t[11],m=t[15],_=l*f-c*u,M=a*f-c*d,y=a*u-l*d,T=o*f-c*h,E=o*u-l*h,v=o*d-a*h;return e*(x*_-p*M+m*y)-n*(g*_-p*T+m*E)+s*(g*M-x*T+m*v)-r*(g*y-x*E+p*v)}determinantAffine(){let t=this.elements,e=t[0],n=t[4],s=t[8],r=t[1],o=t[5],a=t[9],l=t[2],c=t[6],h=t[10];return e*(o*h-a*c)-n*(r*h-a*l)+s*(r*c-o*l)}transpose(){let t=this.elements,e;return e=t[1],t[1]=t[4],t[4]=e,e=t[2],t[2]=t[8],t[8]=e,e=t[6],t[6]=t[9],t[9]=e,e=t[3],t[3]=t[12],t[12]=e,e=t[7],t[7]=t[13],t[13]=e,e=t[11],t[11]=t[14],t[14]=e,this}setPosition(t,e,n){let s=this.elements;return t.isVector3?(s[12]=t.x,s[13]=t.y,s[14]=t.z):(s[12]=t,s[13]=e,s[14]=n),this}invert(){let t=this.elements,e=t[0],n=t[1],s=t[2],r=t[3],o=t[4],a=t[5],l=t[6],c=t[7],h=t[8],d=t[9],u=t[10],f=t[11],g=t[12],x=t[13],p=t[14],m=t[15],_=e*a-n*o,M=e*l-s*o,y=e*c-r*o,T=n*l-s*a,E=n*c-r*a,v=s*c-r*l,w=h*x-d*g,F=h*p-u*g,D=h*m-f*g,N=d*p-u*x,O=d*m-f*x,V=u*m-f*p,C=_*V-M*O+y*N+T*D-E*F+v*w;if(C===0)return this.set(0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0);let H=1/C;return t[0]=(a*V-l*O+c*N)*H,t[1]=(s*O-n*V-r*N)*H,t[2]=(x*v-p*E+m*T)*H,t[3]=(u*E-d*v-f*T)*H,t[4]=(l*D-o*V-c*F)*H,t[5]=(e*V-s*D+r*F)*H,t[6]=(p*y-g*v-m*M)*H,t[7]=(h*v-u*y+f*M)*H,t[8]=(o*O-a*D+c*w)*H,t[9]=(n*D-e*O-r*w)*H,t[10]=(g*E-x*y+m*_)*H,t[11]=(d*y-h*E-f*_)*H,t[12]=(a*F-o*N-l*w)*H,t[13]=(e*N-n*F+s*w)*H,t[14]=(x*M-g*T-p*_)*H,t[15]=(h*T-d*M+u*_)*H,this}scale(t){let e=this.elements,n=t.x,s=t.y,r=t.z;return e[0]*=n,e[4]*=s,e[8]*=r,e[1]*=n,e[5]*=s,e[9]*=r,e[2]*=n,e[6]*=s,e[10]*=r,e[3]*=n,e[7]*=s,e[11]*=r,this}getMaxScaleOnAxis(){let t=this.elements,e=t[0]*t[0]+t[1]*t[1]+t[2]*t[2],n=t[4]*t[4]+t[5]*t[5]+t[6]*t[6],s=t[8]*t[8]+t[9]*t[9]+t[10]*t[10];return Math.sqrt(Math.max(e,n,s))}makeTranslation(t,e,n){return t.isVector3?this.set(1,0,0,t.x,0,1,0,t.y,0,0,1,t.z,0,0,0,1):this.set(1,0,0,t,0,1,0,e,0,0,1,n,0,0,0,1),this}makeRotationX(t){let e=Math.cos(t),n=Math.sin(t);return this.set(1,0,0,0,0,e,-n,0,0,n,e,0,0,0,0,1),this}makeRotationY(t){let e=Math.cos(t),n=Math.sin(t);return this.set(e,0,n,0,0,1,0,0,-n,0,e,0,0,0,0,1),this}makeRotationZ(t){let e=Math.cos(t),n=Math.sin(t);return this.set(e,-n,0,0,n,e,0,0,0,0,1,0,0,0,0,1),this}makeRotationAxis(t,e){let n=Math.cos(e),s=Math.sin(e),r=1-n,o=t.x,a=t.y,l=t.z,c=r*o,h=r*a;return this.set(c*o+n,c*a-s*l,c*l+s*a,0,c*a+s*l,h*a+n,h*l-s*o,0,c*l-s*a,h*l+s*o,r*l*l+n,0,0,0,0,1),this}makeScale(t,e,n){return this.set(t,0,0,0,0,e,0,0,0,0,n,0,0,0,0,1),this}makeShear(t,e,n,s,r,o){return this.set(1,n,r,0,t,1,o,0,e,s,1,0,0,0,0,1),this}compose(t,e,n){let s=this.elements,r=e._x,o=e._y,a=e._z,l=e._w,c=r+r,h=o+o,d=a+a,u=r*c,f=r*h,g=r*d,x=o*h,p=o*d,m=a*d,_=l*c,M=l*h,y=l*d,T=n.x,E=n.y,v=n.z;return s[0]=(1-(x+m))*T,s[1]=(f+y)*T,s[2]=(g-M)*T,s[3]=0,s[4]=(f-y)*E,s[5]=(1-(u+m))*E,s[6]=(p+_)*E,s[7]=0,s[8]=(g+M)*v,s[9]=(p-_)*v,s[10]=(1-(u+x))*v,s[11]=0,s[12]=t.x,s[13]=t.y,s[14]=t.z,s[15]=1,this}decompose(t,e,n){let s=this.elements;t.x=s[12],t.y=s[13],t.z=s[14];let r=this.determinantAffine();if(r===0)return n.set(1,1,1),e.identity(),this;let o=ds.set(s[0],s[1],s[2]).length(),a=ds.set(s[4],s[5],s[6]).length(),l=ds.set(s[8],s[9],s[10]).length();r<0&&(o=-o),Nn.copy(this);let c=1/o,h=1/a,d=1/l;return Nn.elements[0]*=c,Nn.elements[1]*=c,Nn.elements[2]*=c,Nn.elements[4]*=h,Nn.elements[5]*=h,Nn.elements[6]*=h,Nn.elements[8]*=d,Nn.elements[9]*=d,Nn.elements[10]*=d,e.setFromRotationMatrix(Nn),n.x=o,n.y=a,n.z=l,this}makePerspective(t,e,n,s,r,o,a=Tn,l=!1){let c=this.elements,h=2*r/(e-t),d=2*r/(n-s),u=(e+t)/(e-t),f=(n+s)/(n-s),g,x;if(l)g=r/(o-r),x=o*r/(o-r);else if(a===Tn)g=-(o+r)/(o-r),x=-2*o*r/(o-r);else if(a===vr)g=-o/(o-r),x=-o*r/(o-r);else throw new Error("THREE.Matrix4.makePerspective(): Invalid coordinate system: "+a);return c[0]=h,c[4]=0,c[8]=u,c[12]=0,c[1]=0,c[5]=d,c[9]=f,c[13]=0,c[2]=0,c[6]=0,c[10]=g,c[14]=x,c[3]=0,c[7]=0,c[11]=-1,c[15]=0,this}makeOrthographic(t,e,n,s,r,o,a=Tn,l=!1){let c=this.elements,h=2/(e-t),d=2/(n-s),u=-(e+t)/(e-t),f=-(n+s)/(n-s),g,x;if(l)g=1/(o-r),x=o/(o-r);else if(a===Tn)g=-2/(o-r),x=-(o+r)/(o-r);else if(a===vr)g=-1/(o-r),x=-r/(o-r);else throw new Error("THREE.Matrix4.makeOrthographic(): Invalid coordinate system: "+a);return c[0]=h,c[4]=0,c[8]=0,c[12]=u,c[1]=0,c[5]=d,c[9]=0,c[13]=f,c[2]=0,c[6]=0,c[10]=g,c[14]=x,c[3]=0,c[7]=0,c[11]=0,c[15]=1,this}equals(t){let e=this.elements,n=t.elements;for(let s=0;s<16;s++)if(e[s]!==n[s])return!1;return!0}fromArray(t,e=0){for(let n=0;n<16;n++)this.elements[n]=t[n+e];return this}toArray(t=[],e=0){let n=this.elements;return t[e]=n[0],t[e+1]=n[1],t[e+2]=n[2],t[e+3]=n[3],t[e+4]=n[4],t[e+5]=n[5],t[e+6]=n[6],t[e+7]=n[7],t[e+8]=n[8],t[e+9]=n[9],t[e+10]=n[10],t[e+11]=n[11],t[e+12]=n[12],t[e+13]=n[13],t[e+14]=n[14],t[e+15]=n[15],t}},ds=new P,Nn=new jt,q0=new P(0,0,0),Y0=new P(1,1,1),Ti=new P,Ao=new P,hn=new P,Hd=new jt,Gd=new fn,Di=class i{constructor(t=0,e=0,n=0,s=i.DEFAULT_ORDER){this.isEuler=!0,this._x=t,this._y=e,this._z=n,this._order=s}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get order(){return this._order}set order(t){this._order=t,this._onChangeCallback()}set(t,e,n,s=this._order){return this._x=t,this._y=e,this._z=n,this._order=s,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._order)}copy(t){return this._x=t._x,this._y=t._y,this._z=t._z,this._order=t._order,this._onChangeCallback(),this}setFromRotationMatrix(t,e=this._order,n=!0){let s=t.elements,r=s[0],o=s[4],a=s[8],l=s[1],c=s[5],h=s[9],d=s[2],u=s[6],f=s[10];switch(e){case"XYZ":this._y=Math.asin(Ft(a,-1,1)),Math.abs(a)<.9999999?(this._x=Math.atan2(-h,f),this._z=Math.atan2(-o,r)):(this._x=Math.atan2(u,c),this._z=0);break;case"YXZ":this._x=Math.asin(-Ft(h,-1,1)),Math.abs(h)<.9999999?(this._y=Math.atan2(a,f),this._z=Math.atan2(l,c)):(this._y=Math.atan2(-d,r),this._z=0);break;case"ZXY":this._x=Math.asin(Ft(u,-1,1)),Math.abs(u)<.9999999?(this._y=Math.atan2(-d,f),this._z=Math.atan2(-o,c)):(this._y=0,this._z=Math.atan2(l,r));break;case"ZYX":this._y=Math.asin(-Ft(d,-1,1)),Math.abs(d)<.9999999?(this._x=Math.atan2(u,f),this._z=Math.atan2(l,r)):(this._x=0,this._z=Math.atan2(-o,c));break;case"YZX":this._z=Math.asin(Ft(l,-1,1)),Math.abs(l)<.9999999?(this._x=Math.atan2(-h,c),this._y=Math.atan2(-d,r)):(this._x=0,this._y=Math.atan2(a,f));break;case"XZY":this._z=Math.asin(-Ft(o,-1,1)),Math.abs(o)<.9999999?(this._x=Math.atan2(u,c),this._y=Math.atan2(a,r)):(this._x=Math.atan2(-h,f),this._y=0);break;default:Tt("Euler: .setFromRotationMatrix() encountered an unknown order: "+e)}return this._order=e,n===!0&&this._onChangeCallback(),this}setFromQuaternion(t,e,n){return Hd.makeRotationFromQuaternion(t),this.setFromRotationMatrix(Hd,e,n)}setFromVector3(t,e=this._order){return this.set(t.x,t.y,t.z,e)}reorder(t){return Gd.setFromEuler(this),this.setFromQuaternion(Gd,t)}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._order===this._order}fromArray(t){return this._x=t[0],this._y=t[1],this._z=t[2],t[3]!==void 0&&(this._order=t[3]),this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._order,t}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._order}};Di.DEFAULT_ORDER="XYZ";var Ls=class{constructor(){this.mask=1}set(t){this.mask=(1<<t|0)>>>0}enable(t){this.mask|=1<<t|0}enableAll(){this.mask=-1}toggle(t){this.mask^=1<<t|0}disable(t){this.mask&=~(1<<t|0)}disableAll(){this.mask=0}test(t){return(this.mask&t.mask)!==0}isEnabled(t){return(this.mask&(1<<t|0))!==0}},j0=0,Vd=new P,fs=new fn,ri=new jt,To=new P,rr=new P,Z0=new P,K0=new fn,Wd=new P(1,0,0),$d=new P(0,1,0),Xd=new P(0,0,1),qd={type:"added"},J0={type:"removed"},ps={type:"childadded",child:null},qc={type:"childremoved",child:null},an=class i extends On{constructor(){super(),this.isObject3D=!0,Object.defineProperty(this,"id",{value:j0++}),this.uuid=Hi(),this.name="",this.type="Object3D",this.parent=null,this.children=[],this.up=i.DEFAULT_UP.clone();let t=new P,e=new Di,n=new fn,s=new P(1,1,1);function r(){n.setFromEuler(e,!1)}function o(){e.setFromQuaternion(n,void 0,!1)}e._onChange(r),n._onChange(o),Object.defineProperties(this,{position:{configurable:!0,enumerable:!0,value:t},rotation:{configurable:!0,enumerable:!0,value:e},quaternion:{configurable:!0,enumerable:!0,value:n},scale:{configurable:!0,enumerable:!0,value:s},modelViewMatrix:{value:new jt},normalMatrix:{value:new Nt}}),this.matrix=new jt,this.matrixWorld=new jt,this.matrixAutoUpdate=i.DEFAULT_MATRIX_AUTO_UPDATE,this.matrixWorldAutoUpdate=i.DEFAULT_MATRIX_WORLD_AUTO_UPDATE,this.matrixWorldNeedsUpdate=!1,this.layers=new Ls,this.visible=!0,this.castShadow=!1,this.receiveShadow=!1,this.frustumCulled=!0,this.renderOrder=0,this.animations=[],this.customDepthMaterial=void 0,this.customDistanceMaterial=void 0,this.static=!1,this.userData={},this.pivot=null}onBeforeShadow(){}onAfterShadow(){}onBeforeRender(){}onAfterRender(){}applyMatrix4(t){this.matrixAutoUpdate&&this.updateMatrix(),this.matrix.premultiply(t),this.matrix.decompose(this.position,this.quaternion,this.scale),this.pivot!==null&&this.position.copy(this.pivot).applyMatrix4(this.matrix).sub(this.pivot)}applyQuaternion(t){return this.quaternion.premultiply(t),this}setRotationFromAxisAngle(t,e){this.quaternion.setFromAxisAngle(t,e)}setRotationFromEuler(t){this.quaternion.setFromEuler(t,!0)}setRotationFromMatrix(t){this.quaternion.setFromRotationMatrix(t)}setRotationFromQuaternion(t){this.quaternion.copy(t)}rotateOnAxis(t,e){return fs.setFromAxisAngle(t,e),this.quaternion.multiply(fs),this}rotateOnWorldAxis(t,e){return fs.setFromAxisAngle(t,e),this.quaternion.premultiply(fs),this}rotateX(t){return this.rotateOnAxis(Wd,t)}rotateY(t){return this.rotateOnAxis($d,t)}rotateZ(t){return this.rotateOnAxis(Xd,t)}translateOnAxis(t,e){return Vd.copy(t).applyQuaternion(this.quaternion),this.position.add(Vd.multiplyScalar(e)),this}translateX(t){return this.translateOnAxis(Wd,t)}translateY(t){return this.translateOnAxis($d,t)}translateZ(t){return this.translateOnAxis(Xd,t)}localToWorld(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(this.matrixWorld)}worldToLocal(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(ri.copy(this.matrixWorld).invert())}lookAt(t,e,n){t.isVector3?To.copy(t):To.set(t,e,n);let s=this.parent;this.updateWorldMatrix(!0,!1),rr.setFromMatrixPosition(this.matrixWorld),this.isCamera||this.isLight?ri.lookAt(rr,To,this.up):ri.lookAt(To,rr,this.up),this.quaternion.setFromRotationMatrix(ri),s&&(ri.extractRotation(s.matrixWorld),fs.setFromRotationMatrix(ri),this.quaternion.premultiply(fs.invert()))}add(t){if(arguments.length>1){for(let e=0;e<arguments.length;e++)this.add(arguments[e]);return this}return t===this?(Lt("Object3D.add: object can't be added as a child of itself.",t),this):(t&&t.isObject3D?(t.removeFromParent(),t.parent=this,this.children.push(t),t.dispatchEvent(qd),ps.child=t,this.dispatchEvent(ps),ps.child=null):Lt("Object3D.add: object not an instance of THREE.Object3D.",t),this)}remove(t){if(arguments.length>1){for(let n=0;n<arguments.length;n++)this.remove(arguments[n]);return this}let e=this.children.indexOf(t);return e!==-1&&(t.parent=null,this.children.splice(e,1),t.dispatchEvent(J0),qc.child=t,this.dispatchEvent(qc),qc.child=null),this}removeFromParent(){let t=this.parent;return t!==null&&t.remove(this),this}clear(){return this.remove(...this.children)}attach(t){return this.updateWorldMatrix(!0,!1),ri.copy(this.matrixWorld).invert(),t.parent!==null&&(t.parent.updateWorldMatrix(!0,!1),ri.multiply(t.parent.matrixWorld)),t.applyMatrix4(ri),t.removeFromParent(),t.parent=this,this.children.push(t),t.updateWorldMatrix(!1,!0),t.dispatchEvent(qd),ps.child=t,this.dispatchEvent(ps),ps.child=null,this}getObjectById(t){return this.getObjectByProperty("id",t)}getObjectByName(t){return this.getObjectByProperty("name",t)}getObjectByProperty(t,e){if(this[t]===e)return this;for(let n=0,s=this.children.length;n<s;n++){let o=this.children[n].getObjectByProperty(t,e);if(o!==void 0)return o}}getObjectsByProperty(t,e,n=[]){this[t]===e&&n.push(this);let s=this.children;for(let r=0,o=s.length;r<o;r++)s[r].getObjectsByProperty(t,e,n);return n}getWorldPosition(t){return this.updateWorldMatrix(!0,!1),t.setFromMatrixPosition(this.matrixWorld)}getWorldQuaternion(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(rr,t,Z0),t}getWorldScale(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(rr,K0,t),t}getWorldDirection(t){this.updateWorldMatrix(!0,!1);let e=this.matrixWorld.elements;return t.set(e[8],e[9],e[10]).normalize()}raycast(){}intersectsFrustum(){return!0}traverse(t){t(this);let e=this.children;for(let n=0,s=e.length;n<s;n++)e[n].traverse(t)}traverseVisible(t){if(this.visible===!1)return;t(this);let e=this.children;for(let n=0,s=e.length;n<s;n++)e[n].traverseVisible(t)}traverseAncestors(t){let e=this.parent;e!==null&&(t(e),e.traverseAncestors(t))}updateMatrix(){this.matrix.compose(this.position,this.quaternion,this.scale);let t=this.pivot;if(t!==null){let e=t.x,n=t.y,s=t.z,r=this.matrix.elements;r[12]+=e-r[0]*e-r[4]*n-r[8]*s,r[13]+=n-r[1]*e-r[5]*n-r[9]*s,r[14]+=s-r[2]*e-r[6]*n-r[10]*s}this.matrixWorldNeedsUpdate=!0}updateMatrixWorld(t){this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||t)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,t=!0);let e=this.children;for(let n=0,s=e.length;n<s;n++)e[n].updateMatrixWorld(t)}updateWorldMatrix(t,e,n=!1){let s=this.parent;if(t===!0&&s!==null&&s.updateWorldMatrix(!0,!1),this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||n)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,n=!0),e===!0){let r=this.children;for(let o=0,a=r.length;o<a;o++)r[o].updateWorldMatrix(!1,!0,n)}}toJSON(t){let e=t===void 0||typeof t=="string",n={};e&&(t={geometries:{},materials:{},textures:{},images:{},shapes:{},skeletons:{},animations:{},nodes:{}},n.metadata={version:4.7,type:"Object",generator:"Object3D.toJSON"});let s={};s.uuid=this.uuid,s.type=this.type,s.name=this.name,s.castShadow=this.castShadow,s.receiveShadow=this.receiveShadow,s.visible=this.visible,s.frustumCulled=this.frustumCulled,s.renderOrder=this.renderOrder,s.static=this.static,s.matrixAutoUpdate=this.matrixAutoUpdate,Object.keys(this.userData).length>0&&(s.userData=this.userData),s.layers=this.layers.mask,s.matrix=this.matrix.toArray(),s.up=this.up.toArray(),this.pivot!==null&&(s.pivot=this.pivot.toArray()),this.morphTargetDictionary!==void 0&&(s.morphTargetDictionary=Object.assign({},this.morphTargetDictionary)),this.morphTargetInfluences!==void 0&&(s.morphTargetInfluences=this.morphTargetInfluences.slice()),this.isInstancedMesh&&(s.type="InstancedMesh",s.count=this.count,s.instanceMatrix=this.instanceMatrix.toJSON(),this.instanceColor!==null&&(s.instanceColor=this.instanceColor.toJSON())),this.isBatchedMesh&&(s.type="BatchedMesh",s.perObjectFrustumCulled=this.perObjectFrustumCulled,s.sortObjects=this.sortObjects,s.drawRanges=this._drawRanges,s.reservedRanges=this._reservedRanges,s.geometryInfo=this._geometryInfo.map(a=>({...a,boundingBox:a.boundingBox?a.boundingBox.toJSON():void 0,boundingSphere:a.boundingSphere?a.boundingSphere.toJSON():void 0})),s.instanceInfo=this._instanceInfo.map(a=>({...a})),s.availableInstanceIds=this._availableInstanceIds.slice(),s.availableGeometryIds=this._availableGeometryIds.slice(),s.nextIndexStart=this._nextIndexStart,s.nextVertexStart=this._nextVertexStart,s.geometryCount=this._geometryCount,s.maxInstanceCount=this._maxInstanceCount,s.maxVertexCount=this._maxVertexCount,s.maxIndexCount=this._maxIndexCount,s.geometryInitialized=this._geometryInitialized,s.matricesTexture=this._matricesTexture.toJSON(t),s.indirectTexture=this._indirectTexture.toJSON(t),this._colorsTexture!==null&&(s.colorsTexture=this._colorsTexture.toJSON(t)),this.boundingSphere!==null&&(s.boundingSphere=this.boundingSphere.toJSON()),this.boundingBox!==null&&(s.boundingBox=this.boundingBox.toJSON()));function r(a,l){return a[l.uuid]===void 0&&(a[l.uuid]=l.toJSON(t)),l.uuid}if(this.isScene)this.background&&(this.background.isColor?s.background=this.background.toJSON():this.background.isTexture&&(s.background=this.background.toJSON(t).uuid)),this.environment&&this.environment.isTexture&&this.environment.isRenderTargetTexture!==!0&&(s.environment=this.environment.toJSON(t).uuid);else if(this.isMesh||this.isLine||this.isPoints){s.geometry=r(t.geometries,this.geometry);let a=this.geometry.parameters;if(a!==void 0&&a.shapes!==void 0){let l=a.shapes;if(Array.isArray(l))for(let c=0,h=l.length;c<h;c++){let d=l[c];r(t.shapes,d)}else r(t.shapes,l)}}if(this.isSkinnedMesh&&(s.bindMode=this.bindMode,s.bindMatrix=this.bindMatrix.toArray(),this.skeleton!==void 0&&(r(t.skeletons,this.skeleton),s.skeleton=this.skeleton.uuid)),this.material!==void 0)if(Array.isArray(this.material)){let a=[];for(let l=0,c=this.material.length;l<c;l++)a.push(r(t.materials,this.material[l]));s.material=a}else s.material=r(t.materials,this.material);if(this.children.length>0){s.children=[];for(let a=0;a<this.children.length;a++)s.children.push(this.children[a].toJSON(t).object)}if(this.animations.length>0){s.animations=[];for(let a=0;a<this.animations.length;a++){let l=this.animations[a];s.animations.push(r(t.animations,l))}}if(e){let a=o(t.geometries),l=o(t.materials),c=o(t.textures),h=o(t.images),d=o(t.shapes),u=o(t.skeletons),f=o(t.animations),g=o(t.nodes);a.length>0&&(n.geometries=a),l.length>0&&(n.materials=l),c.length>0&&(n.textures=c),h.length>0&&(n.images=h),d.length>0&&(n.shapes=d),u.length>0&&(n.skeletons=u),f.length>0&&(n.animations=f),g.length>0&&(n.nodes=g)}return n.object=s,n;function o(a){let l=[];for(let c in a){let h=a[c];delete h.metadata,l.push(h)}return l}}clone(t){return new this.constructor().copy(this,t)}copy(t,e=!0){if(this.name=t.name,this.up.copy(t.up),this.position.copy(t.position),this.rotation.order=t.rotation.order,this.quaternion.copy(t.quaternion),this.scale.copy(t.scale),this.pivot=t.pivot!==null?t.pivot.clone():null,this.matrix.copy(t.matrix),this.matrixWorld.copy(t.matrixWorld),this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrixWorldAutoUpdate=t.matrixWorldAutoUpdate,this.matrixWorldNeedsUpdate=t.matrixWorldNeedsUpdate,this.layers.mask=t.layers.mask,this.visible=t.visible,this.castShadow=t.castShadow,this.receiveShadow=t.receiveShadow,this.frustumCulled=t.frustumCulled,this.renderOrder=t.renderOrder,this.static=t.static,this.animations=t.animations.slice(),this.userData=JSON.parse(JSON.stringify(t.userData)),e===!0)for(let n=0;n<t.children.length;n++){let s=t.children[n];this.add(s.clone())}return this}dispose(){this.dispatchEvent({type:"dispose"})}};an.DEFAULT_UP=new P(0,1,0);an.DEFAULT_MATRIX_AUTO_UPDATE=!0;an.DEFAULT_MATRIX_WORLD_AUTO_UPDATE=!0;var Ne=class extends an{constructor(){super(),this.isGroup=!0,this.type="Group"}},Q0={type:"move"},Ds=class{constructor(){this._targetRay=null,this._grip=null,this._hand=null}getHandSpace(){return this._hand===null&&(this._hand=new Ne,this._hand.matrixAutoUpdate=!1,this._hand.visible=!1,this._hand.joints={},this._hand.inputState={pinching:!1}),this._hand}getTargetRaySpace(){return this._targetRay===null&&(this._targetRay=new Ne,this._targetRay.matrixAutoUpdate=!1,this._targetRay.visible=!1,this._targetRay.hasLinearVelocity=!1,this._targetRay.linearVelocity=new P,this._targetRay.hasAngularVelocity=!1,this._targetRay.angularVelocity=new P),this._targetRay}getGripSpace(){return this._grip===null&&(this._grip=new Ne,this._grip.matrixAutoUpdate=!1,this._grip.visible=!1,this._grip.hasLinearVelocity=!1,this._grip.linearVelocity=new P,this._grip.hasAngularVelocity=!1,this._grip.angularVelocity=new P,this._grip.eventsEnabled=!1),this._grip}dispatchEvent(t){return this._targetRay!==null&&this._targetRay.dispatchEvent(t),this._grip!==null&&this._grip.dispatchEvent(t),this._hand!==null&&this._hand.dispatchEvent(t),this}connect(t){if(t&&t.hand){let e=this._hand;if(e)for(let n of t.hand.values())this._getHandJoint(e,n)}return this.dispatchEvent({type:"connected",data:t}),this}disconnect(t){return this.dispatchEvent({type:"disconnected",data:t}),this._targetRay!==null&&(this._targetRay.visible=!1),this._grip!==null&&(this._grip.visible=!1),this._hand!==null&&(this._hand.visible=!1),this}update(t,e,n){let s=null,r=null,o=null,a=this._targetRay,l=this._grip,c=this._hand;if(t&&e.session.visibilityState!=="visible-blurred"){if(c&&t.hand){o=!0;for(let x of t.hand.values()){let p=e.getJointPose(x,n),m=this._getHandJoint(c,x);p!==null&&(m.matrix.fromArray(p.transform.matrix),m.matrix.decompose(m.position,m.quaternion,m.scale),m.matrixWorldNeedsUpdate=!0,m.jointRadius=p.radius),m.visible=p!==null}let h=c.joints["index-finger-tip"],d=c.joints["thumb-tip"],u=h.position.distanceTo(d.position),f=.02,g=.005;c.inputState.pinching&&u>f+g?(c.inputState.pinching=!1,this.dispatchEvent({type:"pinchend",handedness:t.handedness,target:this})):!c.inputState.pinching&&u<=f-g&&(c.inputState.pinching=!0,this.dispatchEvent({type:"pinchstart",handedness:t.handedness,target:this}))}else l!==null&&t.gripSpace&&(r=e.getPose(t.gripSpace,n),r!==null&&(l.matrix.fromArray(r.transform.matrix),l.matrix.decompose(l.position,l.quaternion,l.scale),l.matrixWorldNeedsUpdate=!0,r.linearVelocity?(l.hasLinearVelocity=!0,l.linearVelocity.copy(r.linearVelocity)):l.hasLinearVelocity=!1,r.angularVelocity?(l.hasAngularVelocity=!0,l.angularVelocity.copy(r.angularVelocity)):l.hasAngularVelocity=!1,l.eventsEnabled&&l.dispatchEvent({type:"gripUpdated",data:t,target:this})));a!==null&&(s=e.getPose(t.targetRaySpace,n),s===null&&r!==null&&(s=r),s!==null&&(a.matrix.fromArray(s.transform.matrix),a.matrix.decompose(a.position,a.quaternion,a.scale),a.matrixWorldNeedsUpdate=!0,s.linearVelocity?(a.hasLinearVelocity=!0,a.linearVelocity.copy(s.linearVelocity)):a.hasLinearVelocity=!1,s.angularVelocity?(a.hasAngularVelocity=!0,a.angularVelocity.copy(s.angularVelocity)):a.hasAngularVelocity=!1,this.dispatchEvent(Q0)))}return a!==null&&(a.visible=s!==null),l!==null&&(l.visible=r!==null),c!==null&&(c.visible=o!==null),this}_getHandJoint(t,e){if(t.joints[e.jointName]===void 0){let n=new Ne;n.matrixAutoUpdate=!1,n.visible=!1,t.joints[e.jointName]=n,t.add(n)}return t.joints[e.jointName]}},ep={aliceblue:15792383,antiquewhite:16444375,aqua:65535,aquamarine:8388564,azure:15794175,beige:16119260,bisque:16770244,black:0,blanchedalmond:16772045,blue:255,blueviolet:9055202,brown:10824234,burlywood:14596231,cadetblue:6266528,chartreuse:8388352,chocolate:13789470,coral:16744272,cornflowerblue:6591981,cornsilk:16775388,crimson:14423100,cyan:65535,darkblue:139,darkcyan:35723,darkgoldenrod:12092939,darkgray:11119017,darkgreen:25600,darkgrey:11119017,darkkhaki:12433259,darkmagenta:9109643,darkolivegreen:5597999,darkorange:16747520,darkorchid:10040012,darkred:9109504,darksalmon:15308410,darkseagreen:9419919,darkslateblue:4734347,darkslategray:3100495,darkslategrey:3100495,darkturquoise:52945,darkviolet:9699539,deeppink:16716947,deepskyblue:49151,dimgray:6908265,dimgrey:6908265,dodgerblue:2003199,firebrick:11674146,floralwhite:16775920,forestgreen:2263842,fuchsia:16711935,gainsboro:14474460,ghostwhite:16316671,gold:16766720,goldenrod:14329120,gray:8421504,green:32768,greenyellow:11403055,grey:8421504,honeydew:15794160,hotpink:16738740,indianred:13458524,indigo:4915330,ivory:16777200,khaki:15787660,lavender:15132410,lavenderblush:16773365,lawngreen:8190976,lemonchiffon:16775885,lightblue:11393254,lightcoral:15761536,lightcyan:14745599,lightgoldenrodyellow:16448210,lightgray:13882323,lightgreen:9498256,lightgrey:13882323,lightpink:16758465,lightsalmon:16752762,lightseagreen:2142890,lightskyblue:8900346,lightslategray:7833753,lightslategrey:7833753,lightsteelblue:11584734,lightyellow:16777184,lime:65280,limegreen:3329330,linen:16445670,magenta:16711935,maroon:8388608,mediumaquamarine:6737322,mediumblue:205,mediumorchid:12211667,mediumpurple:9662683,mediumseagreen:3978097,mediumslateblue:8087790,mediumspringgreen:64154,mediumturquoise:4772300,mediumvioletred:13047173,midnightblue:1644912,mintcream:16121850,mistyrose:16770273,moccasin:16770229,navajowhite:16768685,navy:128,oldlace:16643558,olive:8421376,olivedrab:7048739,orange:16753920,orangered:16729344,orchid:14315734,palegoldenrod:15657130,palegreen:10025880,paleturquoise:11529966,palevioletred:14381203,papayawhip:16773077,peachpuff:16767673,peru:13468991,pink:16761035,plum:14524637,powderblue:11591910,purple:8388736,rebeccapurple:6697881,red:16711680,rosybrown:12357519,royalblue:4286945,saddlebrown:9127187,salmon:16416882,sandybrown:16032864,seagreen:3050327,seashell:16774638,sienna:10506797,silver:12632256,skyblue:8900331,slateblue:6970061,slategray:7372944,slategrey:7372944,snow:16775930,springgreen:65407,steelblue:4620980,tan:13808780,teal:32896,thistle:14204888,tomato:16737095,turquoise:4251856,violet:15631086,wheat:16113331,white:16777215,whitesmoke:16119285,yellow:16776960,yellowgreen:10145074},Ci={h:0,s:0,l:0},Co={h:0,s:0,l:0};function Yc(i,t,e){return e<0&&(e+=1),e>1&&(e-=1),e<1/6?i+(t-i)*6*e:e<1/2?t:e<2/3?i+(t-i)*6*(2/3-e):i}var Gt=class{constructor(t,e,n){return this.isColor=!0,this.r=1,this.g=1,this.b=1,this.set(t,e,n)}set(t,e,n){if(e===void 0&&n===void 0){let s=t;s&&s.isColor?this.copy(s):typeof s=="number"?this.setHex(s):typeof s=="string"&&this.setStyle(s)}else this.setRGB(t,e,n);return this}setScalar(t){return this.r=t,this.g=t,this.b=t,this}setHex(t,e=dn){return t=Math.floor(t),this.r=(t>>16&255)/255,this.g=(t>>8&255)/255,this.b=(t&255)/255,Xt.colorSpaceToWorking(this,e),this}setRGB(t,e,n,s=Xt.workingColorSpace){return this.r=t,this.g=e,this.b=n,Xt.colorSpaceToWorking(this,s),this}setHSL(t,e,n,s=Xt.workingColorSpace){if(t=Jh(t,1),e=Ft(e,0,1),n=Ft(n,0,1),e===0)this.r=this.g=this.b=n;else{let r=n<=.5?n*(1+e):n+e-n*e,o=2*n-r;this.r=Yc(o,r,t+1/3),this.g=Yc(o,r,t),this.b=Yc(o,r,t-1/3)}return Xt.colorSpaceToWorking(this,s),this}setStyle(t,e=dn){function n(r){r!==void 0&&parseFloat(r)<1&&Tt("Color: Alpha component of "+t+" will be ignored.")}let s;if(s=/^(\w+)\(([^\)]*)\)/.exec(t)){let r,o=s[1],a=s[2];switch(o){case"rgb":case"rgba":if(r=/^\s*(\d+)\s*,\s*(\d+)\s*,\s*(\d+)\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return n(r[4]),this.setRGB(Math.min(255,parseInt(r[1],10))/255,Math.min(255,parseInt(r[2],10))/255,Math.min(255,parseInt(r[3],10))/255,e);if(r=/^\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return n(r[4]),this.setRGB(Math.min(100,parseFloat(r[1]))/100,Math.min(100,parseFloat(r[2]))/100,Math.min(100,parseFloat(r[3]))/100,e);break;case"hsl":case"hsla":if(r=/^\s*([+-]?(?:\d+(?:\.\d+)?|\.\d+))\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return n(r[4]),this.setHSL(parseFloat(r[1])/360,parseFloat(r[2])/100,parseFloat(r[3])/100,e);break;default:Tt("Color: Unknown color model "+t)}}else if(s=/^\#([A-Fa-f\d]+)$/.exec(t)){let r=s[1],o=r.length;if(o===3)return this.setRGB(parseInt(r.charAt(0),16)/15,parseInt(r.charAt(1),16)/15,parseInt(r.charAt(2),16)/15,e);if(o===6)return this.setHex(parseInt(r,16),e);Tt("Color: Invalid hex color "+t)}else if(t&&t.length>0)return this.setColorName(t,e);return this}setColorName(t,e=dn){let n=ep[t.toLowerCase()];return n!==void 0?this.setHex(n,e):Tt("Color: Unknown color "+t),this}clone(){return new this.constructor(this.r,this.g,this.b)}copy(t){return this.r=t.r,this.g=t.g,this.b=t.b,this}copySRGBToLinear(t){return this.r=ui(t.r),this.g=ui(t.g),this.b=ui(t.b),this}copyLinearToSRGB(t){return this.r=As(t.r),this.g=As(t.g),this.b=As(t.b),this}convertSRGBToLinear(){return this.copySRGBToLinear(this),this}convertLinearToSRGB(){return this.copyLinearToSRGB(this),this}getHex(t=dn){return Xt.workingToColorSpace($e.copy(this),t),Math.round(Ft($e.r*255,0,255))*65536+Math.round(Ft($e.g*255,0,255))*256+Math.round(Ft($e.b*255,0,255))}getHexString(t=dn){return("000000"+this.getHex(t).toString(16)).slice(-6)}getHSL(t,e=Xt.workingColorSpace){Xt.workingToColorSpace($e.copy(this),e);let n=$e.r,s=$e.g,r=$e.b,o=Math.max(n,s,r),a=Math.min(n,s,r),l,c,h=(a+o)/2;if(a===o)l=0,c=0;else{let d=o-a;switch(c=h<=.5?d/(o+a):d/(2-o-a),o){case n:l=(s-r)/d+(s<r?6:0);break;case s:l=(r-n)/d+2;break;case r:l=(n-s)/d+4;break}l/=6}return t.h=l,t.s=c,t.l=h,t}getRGB(t,e=Xt.workingColorSpace){return Xt.workingToColorSpace($e.copy(this),e),t.r=$e.r,t.g=$e.g,t.b=$e.b,t}getStyle(t=dn){Xt.workingToColorSpace($e.copy(this),t);let e=$e.r,n=$e.g,s=$e.b;return t!==dn?`color(${t} ${e.toFixed(3)} ${n.toFixed(3)} ${s.toFixed(3)})`:`rgb(${Math.round(e*255)},${Math.round(n*255)},${Math.round(s*255)})`}offsetHSL(t,e,n){return this.getHSL(Ci),this.setHSL(Ci.h+t,Ci.s+e,Ci.l+n)}add(t){return this.r+=t.r,this.g+=t.g,this.b+=t.b,this}addColors(t,e){return this.r=t.r+e.r,this.g=t.g+e.g,this.b=t.b+e.b,this}addScalar(t){return this.r+=t,this.g+=t,this.b+=t,this}sub(t){return this.r=Math.max(0,this.r-t.r),this.g=Math.max(0,this.g-t.g),this.b=Math.max(0,this.b-t.b),this}multiply(t){return this.r*=t.r,this.g*=t.g,this.b*=t.b,this}multiplyScalar(t){return this.r*=t,this.g*=t,this.b*=t,this}lerp(t,e){return this.r+=(t.r-this.r)*e,this.g+=(t.g-this.g)*e,this.b+=(t.b-this.b)*e,this}lerpColors(t,e,n){return this.r=t.r+(e.r-t.r)*n,this.g=t.g+(e.g-t.g)*n,this.b=t.b+(e.b-t.b)*n,this}lerpHSL(t,e){this.getHSL(Ci),t.getHSL(Co);let n=fr(Ci.h,Co.h,e),s=fr(Ci.s,Co.s,e),r=fr(Ci.l,Co.l,e);return this.setHSL(n,s,r),this}setFromVector3(t){return this.r=t.x,this.g=t.y,this.b=t.z,this}applyMatrix3(t){let e=this.r,n=this.g,s=this.b,r=t.elements;return this.r=r[0]*e+r[3]*n+r[6]*s,this.g=r[1]*e+r[4]*n+r[7]*s,this.b=r[2]*e+r[5]*n+r[8]*s,this}equals(t){return t.r===this.r&&t.g===this.g&&t.b===this.b}fromArray(t,e=0){return this.r=t[e],this.g=t[e+1],this.b=t[e+2],this}toArray(t=[],e=0){return t[e]=this.r,t[e+1]=this.g,t[e+2]=this.b,t}fromBufferAttribute(t,e){return this.r=t.getX(e),this.g=t.getY(e),this.b=t.getZ(e),this}toJSON(){return this.getHex()}*[Symbol.iterator](){yield this.r,yield this.g,yield this.b}},$e=new Gt;Gt.NAMES=ep;var br=class extends an{constructor(){super(),this.isScene=!0,this.type="Scene",this.background=null,this.environment=null,this.fog=null,this.backgroundBlurriness=0,this.backgroundIntensity=1,this.backgroundRotation=new Di,this.environmentIntensity=1,this.environmentRotation=new Di,this.overrideMaterial=null}copy(t,e){return super.copy(t,e),this.background=t.background!==null?t.background.clone():null,this.environment=t.environment!==null?t.environment.clone():null,this.fog=t.fog!==null?t.fog.clone():null,this.backgroundBlurriness=t.backgroundBlurriness,this.backgroundIntensity=t.backgroundIntensity,this.backgroundRotation.copy(t.backgroundRotation),this.environmentIntensity=t.environmentIntensity,this.environmentRotation.copy(t.environmentRotation),this.overrideMaterial=t.overrideMaterial!==null?t.overrideMaterial.clone():null,this.matrixAutoUpdate=t.matrixAutoUpdate,this}toJSON(t){let e=super.toJSON(t);return this.fog!==null&&(e.object.fog=this.fog.toJSON()),e.object.backgroundBlurriness=this.backgroundBlurriness,e.object.backgroundIntensity=this.backgroundIntensity,e.object.backgroundRotation=this.backgroundRotation.toArray(),e.object.environmentIntensity=this.environmentIntensity,e.object.environmentRotation=this.environmentRotation.toArray(),e}},Un=new P,oi=new P,jc=new P,ai=new P,ms=new P,gs=new P,Yd=new P,Zc=new P,Kc=new P,Jc=new P,Qc=new ne,th=new ne,eh=new ne,Li=class i{constructor(t=new P,e=new P,n=new P){this.a=t,this.b=e,this.c=n}static getNormal(t,e,n,s){s.subVectors(n,e),Un.subVectors(t,e),s.cross(Un);let r=s.lengthSq();return r>0?s.multiplyScalar(1/Math.sqrt(r)):s.set(0,0,0)}static getBarycoord(t,e,n,s,r){Un.subVectors(s,e),oi.subVectors(n,e),jc.subVectors(t,e);let o=Un.dot(Un),a=Un.dot(oi),l=Un.dot(jc),c=oi.dot(oi),h=oi.dot(jc),d=o*c-a*a;if(d===0)return r.set(0,0,0),null;let u=1/d,f=(c*l-a*h)*u,g=(o*h-a*l)*u;return r.set(1-f-g,g,f)}static containsPoint(t,e,n,s){return this.getBarycoord(t,e,n,s,ai)===null?!1:ai.x>=0&&ai.y>=0&&ai.x+ai.y<=1}static getInterpolation(t,e,n,s,r,o,a,l){return this.getBarycoord(t,e,n,s,ai)===null?(l.x=0,l.y=0,"z"in l&&(l.z=0),"w"in l&&(l.w=0),null):(l.setScalar(0),l.addScaledVector(r,ai.x),l.addScaledVector(o,ai.y),l.addScaledVector(a,ai.z),l)}static getInterpolatedAttribute(t,e,n,s,r,o){return Qc.setScalar(0),th.setScalar(0),eh.setScalar(0),Qc.fromBufferAttribute(t,e),th.fromBufferAttribute(t,n),eh.fromBufferAttribute(t,s),o.setScalar(0),o.addScaledVector(Qc,r.x),o.addScaledVector(th,r.y),o.addScaledVector(eh,r.z),o}static isFrontFacing(t,e,n,s){return Un.subVectors(n,e),oi.subVectors(t,e),Un.cross(oi).dot(s)<0}set(t,e,n){return this.a.copy(t),this.b.copy(e),this.c.copy(n),this}setFromPointsAndIndices(t,e,n,s){return this.a.copy(t[e]),this.b.copy(t[n]),this.c.copy(t[s]),this}setFromAttributeAndIndices(t,e,n,s){return this.a.fromBufferAttribute(t,e),this.b.fromBufferAttribute(t,n),this.c.fromBufferAttribute(t,s),this}clone(){return new this.constructor().copy(this)}copy(t){return this.a.copy(t.a),this.b.copy(t.b),this.c.copy(t.c),this}getArea(){return Un.subVectors(this.c,this.b),oi.subVectors(this.a,this.b),Un.cross(oi).length()*.5}getMidpoint(t){return t.addVectors(this.a,this.b).add(this.c).multiplyScalar(1/3)}getNormal(t){return i.getNormal(this.a,this.b,this.c,t)}getPlane(t){return t.setFromCoplanarPoints(this.a,this.b,this.c)}getBarycoord(t,e){return i.getBarycoord(t,this.a,this.b,this.c,e)}getInterpolation(t,e,n,s,r){return i.getInterpolation(t,this.a,this.b,this.c,e,n,s,r)}containsPoint(t){return i.containsPoint(t,this.a,this.b,this.c)}isFrontFacing(t){return i.isFrontFacing(this.a,this.b,this.c,t)}intersectsBox(t){return t.intersectsTriangle(this)}closestPointToPoint(t,e){let n=this.a,s=this.b,r=this.c,o,a;ms.subVectors(s,n),gs.subVectors(r,n),Zc.subVectors(t,n);let l=ms.dot(Zc),c=gs.dot(Zc);if(l<=0&&c<=0)return e.copy(n);Kc.subVectors(t,s);let h=ms.dot(Kc),d=gs.dot(Kc);if(h>=0&&d<=h)return e.copy(s);let u=l*d-h*c;if(u<=0&&l>=0&&h<=0&&l-h>0)return o=l/(l-h),e.copy(n).addScaledVector(ms,o);Jc.subVectors(t,r);let f=ms.dot(Jc),g=gs.dot(Jc);if(g>=0&&f<=g)return e.copy(r);let x=f*c-l*g;if(x<=0&&c>=0&&g<=0)return a=c/(c-g),e.copy(n).addScaledVector(gs,a);let p=h*g-f*d;if(p<=0&&d-h>=0&&f-g>=0)return Yd.subVectors(r,s),a=(d-h)/(d-h+(f-g)),e.copy(s).addScaledVector(Yd,a);let m=1/(p+x+u);return o=x*m,a=u*m,e.copy(n).addScaledVector(ms,o).addScaledVector(gs,a)}equals(t){return t.a.equals(this.a)&&t.b.equals(this.b)&&t.c.equals(this.c)}},ve=class{constructor(t=new P(1/0,1/0,1/0),e=new P(-1/0,-1/0,-1/0)){this.isBox3=!0,this.min=t,this.max=e}set(t,e){return this.min.copy(t),this.max.copy(e),this}setFromArray(t){this.makeEmpty();for(let e=0,n=t.length;e<n;e+=3)this.expandByPoint(Fn.fromArray(t,e));return this}setFromBufferAttribute(t){this.makeEmpty();for(let e=0,n=t.count;e<n;e++)this.expandByPoint(Fn.fromBufferAttribute(t,e));return this}setFromPoints(t){this.makeEmpty();for(let e=0,n=t.length;e<n;e++)this.expandByPoint(t[e]);return this}setFromCenterAndSize(t,e){let n=Fn.copy(e).multiplyScalar(.5);return this.min.copy(t).sub(n),this.max.copy(t).add(n),this}setFromObject(t,e=!1){return this.makeEmpty(),this.expandByObject(t,e)}clone(){return new this.constructor().copy(this)}copy(t){return this.min.copy(t.min),this.max.copy(t.max),this}makeEmpty(){return this.min.x=this.min.y=this.min.z=1/0,this.max.x=this.max.y=this.max.z=-1/0,this}isEmpty(){return this.max.x<this.min.x||this.max.y<this.min.y||this.max.z<this.min.z}getCenter(t){return this.isEmpty()?t.set(0,0,0):t.addVectors(this.min,this.max).multiplyScalar(.5)}getSize(t){return this.isEmpty()?t.set(0,0,0):t.subVectors(this.max,this.min)}expandByPoint(t){return this.min.min(t),this.max.max(t),this}expandByVector(t){return this.min.sub(t),this.max.add(t),this}expandByScalar(t){return this.min.addScalar(-t),this.max.addScalar(t),this}expandByObject(t,e=!1){t.updateWorldMatrix(!1,!1);let n=t.geometry;if(n!==void 0){let r=n.getAttribute("position");if(e===!0&&r!==void 0&&t.isInstancedMesh!==!0&&t.isBatchedMesh!==!0)for(let o=0,a=r.count;o<a;o++)t.isMesh===!0?t.getVertexPosition(o,Fn):Fn.fromBufferAttribute(r,o),Fn.applyMatrix4(t.matrixWorld),this.expandByPoint(Fn);else t.boundingBox!==void 0?(t.boundingBox===null&&t.computeBoundingBox(),Ro.copy(t.boundingBox)):(n.boundingBox===null&&n.computeBoundingBox(),Ro.copy(n.boundingBox)),Ro.applyMatrix4(t.matrixWorld),this.union(Ro)}let s=t.children;for(let r=0,o=s.length;r<o;r++)this.expandByObject(s[r],e);return this}containsPoint(t){return t.x>=this.min.x&&t.x<=this.max.x&&t.y>=this.min.y&&t.y<=this.max.y&&t.z>=this.min.z&&t.z<=this.max.z}containsBox(t){return this.min.x<=t.min.x&&t.max.x<=this.max.x&&this.min.y<=t.min.y&&t.max.y<=this.max.y&&this.min.z<=t.min.z&&t.max.z<=this.max.z}getParameter(t,e){return e.set((t.x-this.min.x)/(this.max.x-this.min.x),(t.y-this.min.y)/(this.max.y-this.min.y),(t.z-this.min.z)/(this.max.z-this.min.z))}intersectsBox(t){return t.max.x>=this.min.x&&t.min.x<=this.max.x&&t.max.y>=this.min.y&&t.min.y<=this.max.y&&t.max.z>=this.min.z&&t.min.z<=this.max.z}intersectsSphere(t){return this.clampPoint(t.center,Fn),Fn.distanceToSquared(t.center)<=t.radius*t.radius}intersectsPlane(t){let e,n;return t.normal.x>0?(e=t.normal.x*this.min.x,n=t.normal.x*this.max.x):(e=t.normal.x*this.max.x,n=t.normal.x*this.min.x),t.normal.y>0?(e+=t.normal.y*this.min.y,n+=t.normal.y*this.max.y):(e+=t.normal.y*this.max.y,n+=t.normal.y*this.min.y),t.normal.z>0?(e+=t.normal.z*this.min.z,n+=t.normal.z*this.max.z):(e+=t.normal.z*this.max.z,n+=t.normal.z*this.min.z),e<=-t.constant&&n>=-t.constant}intersectsTriangle(t){if(this.isEmpty())return!1;this.getCenter(or),Po.subVectors(this.max,or),vs.subVectors(t.a,or),xs.subVectors(t.b,or),_s.subVectors(t.c,or),Ri.subVectors(xs,vs),Pi.subVectors(_s,xs),Ki.subVectors(vs,_s);let e=[0,-Ri.z,Ri.y,0,-Pi.z,Pi.y,0,-Ki.z,Ki.y,Ri.z,0,-Ri.x,Pi.z,0,-Pi.x,Ki.z,0,-Ki.x,-Ri.y,Ri.x,0,-Pi.y,Pi.x,0,-Ki.y,Ki.x,0];return!nh(e,vs,xs,_s,Po)||(e=[1,0,0,0,1,0,0,0,1],!nh(e,vs,xs,_s,Po))?!1:(Io.crossVectors(Ri,Pi),e=[Io.x,Io.y,Io.z],nh(e,vs,xs,_s,Po))}clampPoint(t,e){return e.copy(t).clamp(this.min,this.max)}distanceToPoint(t){return this.clampPoint(t,Fn).distanceTo(t)}getBoundingSphere(t){return this.isEmpty()?t.makeEmpty():(this.getCenter(t.center),t.radius=this.getSize(Fn).length()*.5),t}intersect(t){return this.min.max(t.min),this.max.min(t.max),this.isEmpty()&&this.makeEmpty(),this}union(t){return this.min.min(t.min),this.max.max(t.max),this}applyMatrix4(t){return this.isEmpty()?this:(li[0].set(this.min.x,this.min.y,this.min.z).applyMatrix4(t),li[1].set(this.min.x,this.min.y,this.max.z).applyMatrix4(t),li[2].set(this.min.x,this.max.y,this.min.z).applyMatrix4(t),li[3].set(this.min.x,this.max.y,this.max.z).applyMatrix4(t),li[4].set(this.max.x,this.min.y,this.min.z).applyMatrix4(t),li[5].set(this.max.x,this.min.y,this.max.z).applyMatrix4(t),li[6].set(this.max.x,this.max.y,this.min.z).applyMatrix4(t),li[7].set(this.max.x,this.max.y,this.max.z).applyMatrix4(t),this.setFromPoints(li),this)}translate(t){return this.min.add(t),this.max.add(t),this}equals(t){return t.min.equals(this.min)&&t.max.equals(this.max)}toJSON(){return{min:this.min.toArray(),max:this.max.toArray()}}fromJSON(t){return this.min.fromArray(t.min),this.max.fromArray(t.max),this}},li=[new P,new P,new P,new P,new P,new P,new P,new P],Fn=new P,Ro=new ve,vs=new P,xs=new P,_s=new P,Ri=new P,Pi=new P,Ki=new P,or=new P,Po=new P,Io=new P,Ji=new P;function nh(i,t,e,n,s){for(let r=0,o=i.length-3;r<=o;r+=3){Ji.fromArray(i,r);let a=s.x*Math.abs(Ji.x)+s.y*Math.abs(Ji.y)+s.z*Math.abs(Ji.z),l=t.dot(Ji),c=e.dot(Ji),h=n.dot(Ji);if(Math.max(-Math.max(l,c,h),Math.min(l,c,h))>a)return!1}return!0}var hi=tv();function tv(){let i=new ArrayBuffer(4),t=new Float32Array(i),e=new Uint32Array(i),n=new Uint32Array(512),s=new Uint32Array(512);for(let l=0;l<256;++l){let c=l-127;c<-27?(n[l]=0,n[l|256]=32768,s[l]=24,s[l|256]=24):c<-14?(n[l]=1024>>-c-14,n[l|256]=1024>>-c-14|32768,s[l]=-c-1,s[l|256]=-c-1):c<=15?(n[l]=c+15<<10,n[l|256]=c+15<<10|32768,s[l]=13,s[l|256]=13):c<128?(n[l]=31744,n[l|256]=64512,s[l]=24,s[l|256]=24):(n[l]=31744,n[l|256]=64512,s[l]=13,s[l|256]=13)}let r=new Uint32Array(2048),o=new Uint32Array(64),a=new Uint32Array(64);for(let l=1;l<1024;++l){let c=l<<13,h=0;for(;(c&8388608)===0;)c<<=1,h-=8388608;c&=-8388609,h+=947912704,r[l]=c|h}for(let l=1024;l<2048;++l)r[l]=939524096+(l-1024<<13);for(let l=1;l<31;++l)o[l]=l<<23;o[31]=1199570944,o[32]=2147483648;for(let l=33;l<63;++l)o[l]=2147483648+(l-32<<23);o[63]=3347054592;for(let l=1;l<64;++l)l!==32&&(a[l]=1024);return{floatView:t,uint32View:e,baseTable:n,shiftTable:s,mantissaTable:r,exponentTable:o,offsetTable:a}}function ev(i){Math.abs(i)>65504&&Tt("DataUtils.toHalfFloat(): Value out of range."),i=Ft(i,-65504,65504),hi.floatView[0]=i;let t=hi.uint32View[0],e=t>>23&511;return hi.baseTable[e]+((t&8388607)>>hi.shiftTable[e])}function nv(i){let t=i>>10;return hi.uint32View[0]=hi.mantissaTable[hi.offsetTable[t]+(i&1023)]+hi.exponentTable[t],hi.floatView[0]}var Ns=class{static toHalfFloat(t){return ev(t)}static fromHalfFloat(t){return nv(t)}},ye=new P,Lo=new Ct,iv=0,qe=class extends On{constructor(t,e,n=!1){if(super(),Array.isArray(t))throw new TypeError("THREE.BufferAttribute: array should be a Typed Array.");this.isBufferAttribute=!0,Object.defineProperty(this,"id",{value:iv++}),this.name="",this.array=t,this.itemSize=e,this.count=t!==void 0?t.length/e:0,this.normalized=n,this.usage=Zh,this.updateRanges=[],this.gpuType=Gn,this.version=0,this._normalizationScale=t!==void 0?xl(t):void 0}onUploadCallback(){}set needsUpdate(t){t===!0&&this.version++}setUsage(t){return this.usage=t,this}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}copy(t){return this.name=t.name,this.array=new t.array.constructor(t.array),this.itemSize=t.itemSize,this.count=t.count,this.normalized=t.normalized,this.usage=t.usage,this.gpuType=t.gpuType,this._normalizationScale=t._normalizationScale,this}copyAt(t,e,n){t*=this.itemSize,n*=e.itemSize;for(let s=0,r=this.itemSize;s<r;s++)this.array[t+s]=e.array[n+s];return this}copyArray(t){return this.array.set(t),this}applyMatrix3(t){if(this.itemSize===2)for(let e=0,n=this.count;e<n;e++)Lo.fromBufferAttribute(this,e),Lo.applyMatrix3(t),this.setXY(e,Lo.x,Lo.y);else if(this.itemSize===3)for(let e=0,n=this.count;e<n;e++)ye.fromBufferAttribute(this,e),ye.applyMatrix3(t),this.setXYZ(e,ye.x,ye.y,ye.z);return this}applyMatrix4(t){for(let e=0,n=this.count;e<n;e++)ye.fromBufferAttribute(this,e),ye.applyMatrix4(t),this.setXYZ(e,ye.x,ye.y,ye.z);return this}applyNormalMatrix(t){for(let e=0,n=this.count;e<n;e++)ye.fromBufferAttribute(this,e),ye.applyNormalMatrix(t),this.setXYZ(e,ye.x,ye.y,ye.z);return this}transformDirection(t){for(let e=0,n=this.count;e<n;e++)ye.fromBufferAttribute(this,e),ye.transformDirection(t),this.setXYZ(e,ye.x,ye.y,ye.z);return this}set(t,e=0){return this.array.set(t,e),this}getComponent(t,e){let n=this.array[t*this.itemSize+e];return this.normalized&&(n=this._denormalize(n)),n}setComponent(t,e,n){return this.normalized&&(n=this._normalize(n)),this.array[t*this.itemSize+e]=n,this}getX(t){let e=this.array[t*this.itemSize];return this.normalized&&(e=this._denormalize(e)),e}setX(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize]=e,this}getY(t){let e=this.array[t*this.itemSize+1];return this.normalized&&(e=this._denormalize(e)),e}setY(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize+1]=e,this}getZ(t){let e=this.array[t*this.itemSize+2];return this.normalized&&(e=this._denormalize(e)),e}setZ(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize+2]=e,this}getW(t){let e=this.array[t*this.itemSize+3];return this.normalized&&(e=this._denormalize(e)),e}setW(t,e){return this.normalized&&(e=this._normalize(e)),this.array[t*this.itemSize+3]=e,this}setXY(t,e,n){return t*=this.itemSize,this.normalized&&(e=this._normalize(e),n=this._normalize(n)),this.array[t+0]=e,this.array[t+1]=n,this}setXYZ(t,e,n,s){return t*=this.itemSize,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s)),this.array[t+0]=e,this.array[t+1]=n,this.array[t+2]=s,this}setXYZW(t,e,n,s,r){return t*=this.itemSize,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s),r=this._normalize(r)),this.array[t+0]=e,this.array[t+1]=n,this.array[t+2]=s,this.array[t+3]=r,this}onUpload(t){return this.onUploadCallback=t,this}clone(){return new this.constructor(this.array,this.itemSize).copy(this)}toJSON(){let t={itemSize:this.itemSize,type:this.array.constructor.name,array:Array.from(this.array),normalized:this.normalized};return t.name=this.name,t.usage=this.usage,t.gpuType=this.gpuType,t}dispose(){this.dispatchEvent({type:"dispose"})}_denormalize(t){let e=this._normalizationScale;return e!==void 0?Math.max(t/e,-1):tu(t,this.array)}_normalize(t){let e=this._normalizationScale;return e!==void 0?Math.round(t*e):eu(t,this.array)}};var Sr=class extends qe{constructor(t,e,n){super(new Uint16Array(t),e,n)}};var Mr=class extends qe{constructor(t,e,n){super(new Uint32Array(t),e,n)}};var Qt=class extends qe{constructor(t,e,n){super(new Float32Array(t),e,n)}},sv=new ve,ar=new P,ih=new P,ln=class{constructor(t=new P,e=-1){this.isSphere=!0,this.center=t,this.radius=e}set(t,e){return this.center.copy(t),this.radius=e,this}setFromPoints(t,e){let n=this.center;e!==void 0?n.copy(e):sv.setFromPoints(t).getCenter(n);let s=0;for(let r=0,o=t.length;r<o;r++)s=Math.max(s,n.distanceToSquared(t[r]));return this.radius=Math.sqrt(s),this}copy(t){return this.center.copy(t.center),this.radius=t.radius,this}isEmpty(){return this.radius<0}makeEmpty(){return this.center.set(0,0,0),this.radius=-1,this}containsPoint(t){return t.distanceToSquared(this.center)<=this.radius*this.radius}distanceToPoint(t){return t.distanceTo(this.center)-this.radius}intersectsSphere(t){let e=this.radius+t.radius;return t.center.distanceToSquared(this.center)<=e*e}intersectsBox(t){return t.intersectsSphere(this)}intersectsPlane(t){return Math.abs(t.distanceToPoint(this.center))<=this.radius}clampPoint(t,e){let n=this.center.distanceToSquared(t);return e.copy(t),n>this.radius*this.radius&&(e.sub(this.center).normalize(),e.multiplyScalar(this.radius).add(this.center)),e}getBoundingBox(t){return this.isEmpty()?(t.makeEmpty(),t):(t.set(this.center,this.center),t.expandByScalar(this.radius),t)}applyMatrix4(t){return this.center.applyMatrix4(t),this.radius=this.radius*t.getMaxScaleOnAxis(),this}translate(t){return this.center.add(t),this}expandByPoint(t){if(this.isEmpty())return this.center.copy(t),this.radius=0,this;ar.subVectors(t,this.center);let e=ar.lengthSq();if(e>this.radius*this.radius){let n=Math.sqrt(e),s=(n-this.radius)*.5;this.center.addScaledVector(ar,s/n),this.radius+=s}return this}union(t){return t.isEmpty()?this:this.isEmpty()?(this.copy(t),this):(this.center.equals(t.center)===!0?this.radius=Math.max(this.radius,t.radius):(ih.subVectors(t.center,this.center).setLength(t.radius),this.expandByPoint(ar.copy(t.center).add(ih)),this.expandByPoint(ar.copy(t.center).sub(ih))),this)}equals(t){return t.center.equals(this.center)&&t.radius===this.radius}clone(){return new this.constructor().copy(this)}toJSON(){return{radius:this.radius,center:this.center.toArray()}}fromJSON(t){return this.radius=t.radius,this.center.fromArray(t.center),this}},rv=0,An=new jt,sh=new an,ys=new P,un=new ve,lr=new ve,De=new P,he=class i extends On{constructor(){super(),this.isBufferGeometry=!0,Object.defineProperty(this,"id",{value:rv++}),this.uuid=Hi(),this.name="",this.type="BufferGeometry",this.index=null,this.indirect=null,this.indirectOffset=0,this.attributes={},this.morphAttributes={},this.morphTargetsRelative=!1,this.groups=[],this.boundingBox=null,this.boundingSphere=null,this.drawRange={start:0,count:1/0},this.userData={},this._transformed=!1}getIndex(){return this.index}setIndex(t){return Array.isArray(t)?this.index=new(T0(t)?Mr:Sr)(t,1):this.index=t,this}setIndirect(t,e=0){return this.indirect=t,this.indirectOffset=e,this}getIndirect(){return this.indirect}getAttribute(t){return this.attributes[t]}setAttribute(t,e){return this.attributes[t]=e,this}deleteAttribute(t){return delete this.attributes[t],this}hasAttribute(t){return this.attributes[t]!==void 0}addGroup(t,e,n=0){this.groups.push({start:t,count:e,materialIndex:n})}clearGroups(){this.groups=[]}setDrawRange(t,e){this.drawRange.start=t,this.drawRange.count=e}applyMatrix4(t){let e=this.attributes.position;e!==void 0&&(e.applyMatrix4(t),e.needsUpdate=!0);let n=this.attributes.normal;if(n!==void 0){let r=new Nt().getNormalMatrix(t);n.applyNormalMatrix(r),n.needsUpdate=!0}let s=this.attributes.tangent;return s!==void 0&&(s.transformDirection(t),s.needsUpdate=!0),this.boundingBox!==null&&this.computeBoundingBox(),this.boundingSphere!==null&&this.computeBoundingSphere(),this._transformed=!0,this}applyQuaternion(t){return An.makeRotationFromQuaternion(t),this.applyMatrix4(An),this}rotateX(t){return An.makeRotationX(t),this.applyMatrix4(An),this}rotateY(t){return An.makeRotationY(t),this.applyMatrix4(An),this}rotateZ(t){return An.makeRotationZ(t),this.applyMatrix4(An),this}translate(t,e,n){return An.makeTranslation(t,e,n),this.applyMatrix4(An),this}scale(t,e,n){return An.makeScale(t,e,n),this.applyMatrix4(An),this}lookAt(t){return sh.lookAt(t),sh.updateMatrix(),this.applyMatrix4(sh.matrix),this}center(){return this.computeBoundingBox(),this.boundingBox.getCenter(ys).negate(),this.translate(ys.x,ys.y,ys.z),this}setFromPoints(t){let e=this.getAttribute("position");if(e===void 0){let n=[];for(let s=0,r=t.length;s<r;s++){let o=t[s];n.push(o.x,o.y,o.z||0)}this.setAttribute("position",new Qt(n,3))}else{let n=Math.min(t.length,e.count);for(let s=0;s<n;s++){let r=t[s];e.setXYZ(s,r.x,r.y,r.z||0)}t.length>e.count&&Tt("BufferGeometry: Buffer size too small for points data. Use .dispose() and create a new geometry."),e.needsUpdate=!0}return this}computeBoundingBox(){this.boundingBox===null&&(this.boundingBox=new ve);let t=this.attributes.position,e=this.morphAttributes.position;if(t&&t.isGLBufferAttribute){Lt("BufferGeometry.computeBoundingBox(): GLBufferAttribute requires a manual bounding box.",this),this.boundingBox.set(new P(-1/0,-1/0,-1/0),new P(1/0,1/0,1/0));return}if(t!==void 0){if(this.boundingBox.setFromBufferAttribute(t),e)for(let n=0,s=e.length;n<s;n++){let r=e[n];un.setFromBufferAttribute(r),this.morphTargetsRelative?(De.addVectors(this.boundingBox.min,un.min),this.boundingBox.expandByPoint(De),De.addVectors(this.boundingBox.max,un.max),this.boundingBox.expandByPoint(De)):(this.boundingBox.expandByPoint(un.min),this.boundingBox.expandByPoint(un.max))}}else this.boundingBox.makeEmpty();(isNaN(this.boundingBox.min.x)||isNaN(this.boundingBox.min.y)||isNaN(this.boundingBox.min.z))&&Lt('BufferGeometry.computeBoundingBox(): Computed min/max have NaN values. The "position" attribute is likely to have NaN values.',this)}computeBoundingSphere(){this.boundingSphere===null&&(this.boundingSphere=new ln);let t=this.attributes.position,e=this.morphAttributes.position;if(t&&t.isGLBufferAttribute){Lt("BufferGeometry.computeBoundingSphere(): GLBufferAttribute requires a manual bounding sphere.",this),this.boundingSphere.set(new P,1/0);return}if(t){let n=this.boundingSphere.center;if(un.setFromBufferAttribute(t),e)for(let r=0,o=e.length;r<o;r++){let a=e[r];lr.setFromBufferAttribute(a),this.morphTargetsRelative?(De.addVectors(un.min,lr.min),un.expandByPoint(De),De.addVectors(un.max,lr.max),un.expandByPoint(De)):(un.expandByPoint(lr.min),un.expandByPoint(lr.max))}un.getCenter(n);let s=0;for(let r=0,o=t.count;r<o;r++)De.fromBufferAttribute(t,r),s=Math.max(s,n.distanceToSquared(De));if(e)for(let r=0,o=e.length;r<o;r++){let a=e[r],l=this.morphTargetsRelative;for(let c=0,h=a.count;c<h;c++)De.fromBufferAttribute(a,c),l&&(ys.fromBufferAttribute(t,c),De.add(ys)),s=Math.max(s,n.distanceToSquared(De))}this.boundingSphere.radius=Math.sqrt(s),isNaN(this.boundingSphere.radius)&&Lt('BufferGeometry.computeBoundingSphere(): Computed radius is NaN. The "position" attribute is likely to have NaN values.',this)}}computeTangents(){let t=this.index,e=this.attributes;if(t===null||e.position===void 0||e.normal===void 0||e.uv===void 0){Lt("BufferGeometry: .computeTangents() failed. Missing required attributes (index, position, normal or uv)");return}let n=e.position,s=e.normal,r=e.uv,o=this.getAttribute("tangent");(o===void 0||o.count!==n.count)&&(o=new qe(new Float32Array(4*n.count),4),this.setAttribute("tangent",o));let a=[],l=[],c=new Uint8Array(n.count);for(let F=0;F<n.count;F++)a[F]=new P,l[F]=new P;let h=new P,d=new P,u=new P,f=new Ct,g=new Ct,x=new Ct,p=new P,m=new P;function _(F,D,N){c[F]=c[D]=c[N]=1,h.fromBufferAttribute(n,F),d.fromBufferAttribute(n,D),u.fromBufferAttribute(n,N),f.fromBufferAttribute(r,F),g.fromBufferAttribute(r,D),x.fromBufferAttribute(r,N),d.sub(h),u.sub(h),g.sub(f),x.sub(f);let O=1/(g.x*x.y-x.x*g.y);isFinite(O)&&(p.copy(d).multiplyScalar(x.y).addScaledVector(u,-g.y).multiplyScalar(O),m.copy(u).multiplyScalar(g.x).addScaledVector(d,-x.x).multiplyScalar(O),a[F].add(p),a[D].add(p),a[N].add(p),l[F].add(m),l[D].add(m),l[N].add(m))}let M=this.groups;M.length===0&&(M=[{start:0,count:t.count}]);for(let F=0,D=M.length;F<D;++F){let N=M[F],O=N.start,V=N.count;for(let C=O,H=O+V;C<H;C+=3)_(t.getX(C+0),t.getX(C+1),t.getX(C+2))}let y=new P,T=new P,E=new P,v=new P;function w(F){E.fromBufferAttribute(s,F),v.copy(E);let D=a[F];y.copy(D),y.sub(E.multiplyScalar(E.dot(D))).normalize(),T.crossVectors(v,D);let O=T.dot(l[F])<0?-1:1;o.setXYZW(F,y.x,y.y,y.z,O)}for(let F=0,D=n.count;F<D;++F)c[F]&&w(F);this._transformed=!0}computeVertexNormals(){let t=this.index,e=this.getAttribute("position");if(e!==void 0){let n=this.getAttribute("normal");if(n===void 0||n.count!==e.count)n=new qe(new Float32Array(e.count*3),3),this.setAttribute("normal",n);else for(let u=0,f=n.count;u<f;u++)n.setXYZ(u,0,0,0);let s=new P,r=new P,o=new P,a=new P,l=new P,c=new P,h=new P,d=new P;if(t)for(let u=0,f=t.count;u<f;u+=3){let g=t.getX(u+0),x=t.getX(u+1),p=t.getX(u+2);s.fromBufferAttribute(e,g),r.fromBufferAttribute(e,x),o.fromBufferAttribute(e,p),h.subVectors(o,r),d.subVectors(s,r),h.cross(d),a.fromBufferAttribute(n,g),l.fromBufferAttribute(n,x),c.fromBufferAttribute(n,p),a.add(h),l.add(h),c.add(h),n.setXYZ(g,a.x,a.y,a.z),n.setXYZ(x,l.x,l.y,l.z),n.setXYZ(p,c.x,c.y,c.z)}else for(let u=0,f=e.count;u<f;u+=3)s.fromBufferAttribute(e,u+0),r.fromBufferAttribute(e,u+1),o.fromBufferAttribute(e,u+2),h.subVectors(o,r),d.subVectors(s,r),h.cross(d),n.setXYZ(u+0,h.x,h.y,h.z),n.setXYZ(u+1,h.x,h.y,h.z),n.setXYZ(u+2,h.x,h.y,h.z);this.normalizeNormals(),n.needsUpdate=!0}}normalizeNormals(){let t=this.attributes.normal;for(let e=0,n=t.count;e<n;e++)De.fromBufferAttribute(t,e),De.normalize(),t.setXYZ(e,De.x,De.y,De.z)}toNonIndexed(){function t(a,l){let c=a.array,h=a.itemSize,d=a.normalized,u=new c.constructor(l.length*h),f=0,g=0;for(let x=0,p=l.length;x<p;x++){a.isInterleavedBufferAttribute?f=l[x]*a.data.stride+a.offset:f=l[x]*h;for(let m=0;m<h;m++)u[g++]=c[f++]}return new qe(u,h,d)}if(this.index===null)return Tt("BufferGeometry.toNonIndexed(): BufferGeometry is already non-indexed."),this;let e=new i,n=this.index.array,s=this.attributes;for(let a in s){let l=s[a],c=t(l,n);e.setAttribute(a,c)}let r=this.morphAttributes;for(let a in r){let l=[],c=r[a];for(let h=0,d=c.length;h<d;h++){let u=c[h],f=t(u,n);l.push(f)}e.morphAttributes[a]=l}e.morphTargetsRelative=this.morphTargetsRelative;let o=this.groups;for(let a=0,l=o.length;a<l;a++){let c=o[a];e.addGroup(c.start,c.count,c.materialIndex)}return e}toJSON(){let t={metadata:{version:4.7,type:"BufferGeometry",generator:"BufferGeometry.toJSON"}};if(t.uuid=this.uuid,t.type=this.parameters!==void 0&&this._transformed===!0?"BufferGeometry":this.type,t.name=this.name,Object.keys(this.userData).length>0&&(t.userData=this.userData),this.parameters!==void 0&&this._transformed!==!0){let l=this.parameters;for(let c in l)l[c]!==void 0&&(t[c]=l[c]);return t}t.data={attributes:{}};let e=this.index;e!==null&&(t.data.index={type:e.array.constructor.name,array:Array.prototype.slice.call(e.array)});let n=this.attributes;for(let l in n){let c=n[l];t.data.attributes[l]=c.toJSON(t.data)}let s={},r=!1;for(let l in this.morphAttributes){let c=this.morphAttributes[l],h=[];for(let d=0,u=c.length;d<u;d++){let f=c[d];h.push(f.toJSON(t.data))}h.length>0&&(s[l]=h,r=!0)}r&&(t.data.morphAttributes=s,t.data.morphTargetsRelative=this.morphTargetsRelative);let o=this.groups;o.length>0&&(t.data.groups=JSON.parse(JSON.stringify(o)));let a=this.boundingSphere;return a!==null&&(t.data.boundingSphere=a.toJSON()),t}clone(){return new this.constructor().copy(this)}copy(t){this.index=null,this.attributes={},this.morphAttributes={},this.groups=[],this.boundingBox=null,this.boundingSphere=null;let e={};this.name=t.name;let n=t.index;n!==null&&this.setIndex(n.clone());let s=t.attributes;for(let c in s){let h=s[c];this.setAttribute(c,h.clone(e))}let r=t.morphAttributes;for(let c in r){let h=[],d=r[c];for(let u=0,f=d.length;u<f;u++)h.push(d[u].clone(e));this.morphAttributes[c]=h}this.morphTargetsRelative=t.morphTargetsRelative;let o=t.groups;for(let c=0,h=o.length;c<h;c++){let d=o[c];this.addGroup(d.start,d.count,d.materialIndex)}let a=t.boundingBox;a!==null&&(this.boundingBox=a.clone());let l=t.boundingSphere;return l!==null&&(this.boundingSphere=l.clone()),this.drawRange.start=t.drawRange.start,this.drawRange.count=t.drawRange.count,this.userData=t.userData,this._transformed=t._transformed,this}dispose(){this.dispatchEvent({type:"dispose"})}},fa=class{constructor(t,e){this.isInterleavedBuffer=!0,this.array=t,this.stride=e,this.count=t!==void 0?t.length/e:0,this.usage=Zh,this.updateRanges=[],this.version=0,this.uuid=Hi()}onUploadCallback(){}set needsUpdate(t){t===!0&&this.version++}setUsage(t){return this.usage=t,this}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}copy(t){return this.array=new t.array.constructor(t.array),this.count=t.count,this.stride=t.stride,this.usage=t.usage,this}copyAt(t,e,n){t*=this.stride,n*=e.stride;for(let s=0,r=this.stride;s<r;s++)this.array[t+s]=e.array[n+s];return this}set(t,e=0){return this.array.set(t,e),this}clone(t){t.arrayBuffers===void 0&&(t.arrayBuffers={});let e=jd(this.array);t.arrayBuffers[e]===void 0&&(t.arrayBuffers[e]=this.array.slice(0).buffer);let n=new this.array.constructor(t.arrayBuffers[e]),s=new this.constructor(n,this.stride);return s.setUsage(this.usage),s}onUpload(t){return this.onUploadCallback=t,this}toJSON(t){t.arrayBuffers===void 0&&(t.arrayBuffers={});let e=jd(this.array);t.arrayBuffers[e]===void 0&&(t.arrayBuffers[e]=Array.from(new Uint32Array(this.array.slice(0).buffer)));let n={uuid:this.uuid,buffer:e,type:this.array.constructor.name,stride:this.stride};return n.usage=this.usage,n}};function jd(i){return i.buffer._uuid===void 0&&(i.buffer._uuid=Hi()),i.byteOffset===0&&i.byteLength===i.buffer.byteLength?i.buffer._uuid:i.buffer._uuid+":"+i.byteOffset+":"+i.byteLength}var Qe=new P,Bn=class i{constructor(t,e,n,s=!1){this.isInterleavedBufferAttribute=!0,this.name="",this.data=t,this.itemSize=e,this.offset=n,this.normalized=s,this._normalizationScale=t!==void 0?xl(t.array):void 0}get count(){return this.data.count}get array(){return this.data.array}set needsUpdate(t){this.data.needsUpdate=t}applyMatrix4(t){for(let e=0,n=this.data.count;e<n;e++)Qe.fromBufferAttribute(this,e),Qe.applyMatrix4(t),this.setXYZ(e,Qe.x,Qe.y,Qe.z);return this}applyNormalMatrix(t){for(let e=0,n=this.count;e<n;e++)Qe.fromBufferAttribute(this,e),Qe.applyNormalMatrix(t),this.setXYZ(e,Qe.x,Qe.y,Qe.z);return this}transformDirection(t){for(let e=0,n=this.count;e<n;e++)Qe.fromBufferAttribute(this,e),Qe.transformDirection(t),this.setXYZ(e,Qe.x,Qe.y,Qe.z);return this}getComponent(t,e){let n=this.array[t*this.data.stride+this.offset+e];return this.normalized&&(n=this._denormalize(n)),n}setComponent(t,e,n){return this.normalized&&(n=this._normalize(n)),this.data.array[t*this.data.stride+this.offset+e]=n,this}setX(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset]=e,this}setY(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset+1]=e,this}setZ(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset+2]=e,this}setW(t,e){return this.normalized&&(e=this._normalize(e)),this.data.array[t*this.data.stride+this.offset+3]=e,this}getX(t){let e=this.data.array[t*this.data.stride+this.offset];return this.normalized&&(e=this._denormalize(e)),e}getY(t){let e=this.data.array[t*this.data.stride+this.offset+1];return this.normalized&&(e=this._denormalize(e)),e}getZ(t){let e=this.data.array[t*this.data.stride+this.offset+2];return this.normalized&&(e=this._denormalize(e)),e}getW(t){let e=this.data.array[t*this.data.stride+this.offset+3];return this.normalized&&(e=this._denormalize(e)),e}setXY(t,e,n){return t=t*this.data.stride+this.offset,this.normalized&&(e=this._normalize(e),n=this._normalize(n)),this.data.array[t+0]=e,this.data.array[t+1]=n,this}setXYZ(t,e,n,s){return t=t*this.data.stride+this.offset,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s)),this.data.array[t+0]=e,this.data.array[t+1]=n,this.data.array[t+2]=s,this}setXYZW(t,e,n,s,r){return t=t*this.data.stride+this.offset,this.normalized&&(e=this._normalize(e),n=this._normalize(n),s=this._normalize(s),r=this._normalize(r)),this.data.array[t+0]=e,this.data.array[t+1]=n,this.data.array[t+2]=s,this.data.array[t+3]=r,this}clone(t){if(t===void 0){_r("InterleavedBufferAttribute.clone(): Cloning an interleaved buffer attribute will de-interleave buffer data.");let e=[];for(let n=0;n<this.count;n++){let s=n*this.data.stride+this.offset;for(let r=0;r<this.itemSize;r++)e.push(this.data.array[s+r])}return new qe(new this.array.constructor(e),this.itemSize,this.normalized)}else return t.interleavedBuffers===void 0&&(t.interleavedBuffers={}),t.interleavedBuffers[this.data.uuid]===void 0&&(t.interleavedBuffers[this.data.uuid]=this.data.clone(t)),new i(t.interleavedBuffers[this.data.uuid],this.itemSize,this.offset,this.normalized)}toJSON(t){if(t===void 0){_r("InterleavedBufferAttribute.toJSON(): Serializing an interleaved buffer attribute will de-interleave buffer data.");let e=[];for(let n=0;n<this.count;n++){let s=n*this.data.stride+this.offset;for(let r=0;r<this.itemSize;r++)e.push(this.data.array[s+r])}return{itemSize:this.itemSize,type:this.array.constructor.name,array:e,normalized:this.normalized}}else return t.interleavedBuffers===void 0&&(t.interleavedBuffers={}),t.interleavedBuffers[this.data.uuid]===void 0&&(t.interleavedBuffers[this.data.uuid]=this.data.toJSON(t)),{isInterleavedBufferAttribute:!0,itemSize:this.itemSize,data:this.data.uuid,offset:this.offset,normalized:this.normalized}}_denormalize(t){let e=this._normalizationScale;return e!==void 0?Math.max(t/e,-1):tu(t,this.data.array)}_normalize(t){let e=this._normalizationScale;return e!==void 0?Math.round(t*e):eu(t,this.data.array)}},rh=new P,ov=new P,av=new Nt,Xe=class{constructor(t=new P(1,0,0),e=0){this.isPlane=!0,this.normal=t,this.constant=e}set(t,e){return this.normal.copy(t),this.constant=e,this}setComponents(t,e,n,s){return this.normal.set(t,e,n),this.constant=s,this}setFromNormalAndCoplanarPoint(t,e){return this.normal.copy(t),this.constant=-e.dot(this.normal),this}setFromCoplanarPoints(t,e,n){let s=rh.subVectors(n,e).cross(ov.subVectors(t,e)).normalize();return this.setFromNormalAndCoplanarPoint(s,t),this}copy(t){return this.normal.copy(t.normal),this.constant=t.constant,this}normalize(){let t=1/this.normal.length();return this.normal.multiplyScalar(t),this.constant*=t,this}negate(){return this.constant*=-1,this.normal.negate(),this}distanceToPoint(t){return this.normal.dot(t)+this.constant}distanceToSphere(t){return this.distanceToPoint(t.center)-t.radius}projectPoint(t,e){return e.copy(t).addScaledVector(this.normal,-this.distanceToPoint(t))}intersectLine(t,e,n=!0){let s=t.delta(rh),r=this.normal.dot(s);if(r===0)return this.distanceToPoint(t.start)===0?e.copy(t.start):null;let o=-(t.start.dot(this.normal)+this.constant)/r;return n===!0&&(o<0||o>1)?null:e.copy(t.start).addScaledVector(s,o)}intersectsLine(t){let e=this.distanceToPoint(t.start),n=this.distanceToPoint(t.end);return e<0&&n>0||n<0&&e>0}intersectsBox(t){return t.intersectsPlane(this)}intersectsSphere(t){return t.intersectsPlane(this)}coplanarPoint(t){return t.copy(this.normal).multiplyScalar(-this.constant)}applyMatrix4(t,e){let n=e||av.getNormalMatrix(t),s=this.coplanarPoint(rh).applyMatrix4(t),r=this.normal.applyMatrix3(n).normalize();return this.constant=-s.dot(r),this}translate(t){return this.constant-=t.dot(this.normal),this}equals(t){return t.normal.equals(this.normal)&&t.constant===this.constant}clone(){return new this.constructor().copy(this)}toJSON(){return{normal:this.normal.toArray(),constant:this.constant}}fromJSON(t){return this.normal.fromArray(t.normal),this.constant=t.constant,this}},lv=0,fi=class extends On{constructor(){super(),this.isMaterial=!0,Object.defineProperty(this,"id",{value:lv++}),this.uuid=Hi(),this.name="",this.type="Material",this.blending=Hs,this.side=zn,this.vertexColors=!1,this.opacity=1,this.transparent=!1,this.alphaHash=!1,this.blendSrc=Eh,this.blendDst=Ah,this.blendEquation=ss,this.blendSrcAlpha=null,this.blendDstAlpha=null,this.blendEquationAlpha=null,this.blendColor=new Gt(0,0,0),this.blendAlpha=0,this.depthFunc=Ts,this.depthTest=!0,this.depthWrite=!0,this.stencilWriteMask=255,this.stencilFunc=$f,this.stencilRef=0,this.stencilFuncMask=255,this.stencilFail=ta,this.stencilZFail=ta,this.stencilZPass=ta,this.stencilWrite=!1,this.clippingPlanes=null,this.clipIntersection=!1,this.clipShadows=!1,this.shadowSide=null,this.colorWrite=!0,this.precision=null,this.polygonOffset=!1,this.polygonOffsetFactor=0,this.polygonOffsetUnits=0,this.dithering=!1,this.alphaToCoverage=!1,this.premultipliedAlpha=!1,this.forceSinglePass=!1,this.allowOverride=!0,this.visible=!0,this.toneMapped=!0,this.userData={},this.version=0,this._alphaTest=0}get alphaTest(){return this._alphaTest}set alphaTest(t){this._alphaTest>0!=t>0&&this.version++,this._alphaTest=t}onBeforeRender(){}onBeforeCompile(){}customProgramCacheKey(){return this.onBeforeCompile.toString()}setValues(t){if(t!==void 0)for(let e in t){let n=t[e];if(n===void 0){Tt(`Material: parameter '${e}' has value of undefined.`);continue}let s=this[e];if(s===void 0){Tt(`Material: '${e}' is not a property of THREE.${this.type}.`);continue}s&&s.isColor?s.set(n):s&&s.isVector2&&n&&n.isVector2||s&&s.isEuler&&n&&n.isEuler||s&&s.isVector3&&n&&n.isVector3?s.copy(n):this[e]=n}}toJSON(t){let e=t===void 0||typeof t=="string";e&&(t={textures:{},images:{}});let n={metadata:{version:4.7,type:"Material",generator:"Material.toJSON"}};n.uuid=this.uuid,n.type=this.type,n.blending=this.blending,n.side=this.side,n.shadowSide=this.shadowSide,n.vertexColors=this.vertexColors,n.opacity=this.opacity,n.transparent=this.transparent,n.blendSrc=this.blendSrc,n.blendDst=this.blendDst,n.blendEquation=this.blendEquation,n.blendSrcAlpha=this.blendSrcAlpha,n.blendDstAlpha=this.blendDstAlpha,n.blendEquationAlpha=this.blendEquationAlpha,n.blendColor=this.blendColor.getHex(),n.blendAlpha=this.blendAlpha,n.depthFunc=this.depthFunc,n.depthTest=this.depthTest,n.depthWrite=this.depthWrite,n.colorWrite=this.colorWrite,n.clipIntersection=this.clipIntersection,n.clipShadows=this.clipShadows,n.stencilWriteMask=this.stencilWriteMask,n.stencilFunc=this.stencilFunc,n.stencilRef=this.stencilRef,n.stencilFuncMask=this.stencilFuncMask,n.stencilFail=this.stencilFail,n.stencilZFail=this.stencilZFail,n.stencilZPass=this.stencilZPass,n.stencilWrite=this.stencilWrite,n.polygonOffset=this.polygonOffset,n.polygonOffsetFactor=this.polygonOffsetFactor,n.polygonOffsetUnits=this.polygonOffsetUnits,n.dithering=this.dithering,n.alphaTest=this.alphaTest,n.alphaHash=this.alphaHash,n.alphaToCoverage=this.alphaToCoverage,n.premultipliedAlpha=this.premultipliedAlpha,n.forceSinglePass=this.forceSinglePass,n.allowOverride=this.allowOverride,n.visible=this.visible,n.toneMapped=this.toneMapped,n.name=this.name,this.color&&this.color.isColor&&(n.color=this.color.getHex()),this.roughness!==void 0&&(n.roughness=this.roughness),this.metalness!==void 0&&(n.metalness=this.metalness),this.sheen!==void 0&&(n.sheen=this.sheen),this.sheenColor&&this.sheenColor.isColor&&(n.sheenColor=this.sheenColor.getHex()),this.sheenRoughness!==void 0&&(n.sheenRoughness=this.sheenRoughness),this.emissive&&this.emissive.isColor&&(n.emissive=this.emissive.getHex()),this.emissiveIntensity!==void 0&&(n.emissiveIntensity=this.emissiveIntensity),this.specular&&this.specular.isColor&&(n.specular=this.specular.getHex()),this.specularIntensity!==void 0&&(n.specularIntensity=this.specularIntensity),this.specularColor&&this.specularColor.isColor&&(n.specularColor=this.specularColor.getHex()),this.shininess!==void 0&&(n.shininess=this.shininess),this.clearcoat!==void 0&&(n.clearcoat=this.clearcoat),this.clearcoatRoughness!==void 0&&(n.clearcoatRoughness=this.clearcoatRoughness),this.diffuseRoughness!==void 0&&(n.diffuseRoughness=this.diffuseRoughness),this.diffuseRoughnessMap&&this.diffuseRoughnessMap.isTexture&&(n.diffuseRoughnessMap=this.diffuseRoughnessMap.toJSON(t).uuid),this.clearcoatMap&&this.clearcoatMap.isTexture&&(n.clearcoatMap=this.clearcoatMap.toJSON(t).uuid),this.clearcoatRoughnessMap&&this.clearcoatRoughnessMap.isTexture&&(n.clearcoatRoughnessMap=this.clearcoatRoughnessMap.toJSON(t).uuid),this.clearcoatNormalMap&&this.clearcoatNormalMap.isTexture&&(n.clearcoatNormalMap=this.clearcoatNormalMap.toJSON(t).uuid,n.clearcoatNormalScale=this.clearcoatNormalScale.toArray()),this.sheenColorMap&&this.sheenColorMap.isTexture&&(n.sheenColorMap=this.sheenColorMap.toJSON(t).uuid),this.sheenRoughnessMap&&this.sheenRoughnessMap.isTexture&&(n.sheenRoughnessMap=this.sheenRoughnessMap.toJSON(t).uuid),this.dispersion!==void 0&&(n.dispersion=this.dispersion),this.retroreflectivity!==void 0&&(n.retroreflectivity=this.retroreflectivity),this.iridescence!==void 0&&(n.iridescence=this.iridescence),this.iridescenceIOR!==void 0&&(n.iridescenceIOR=this.iridescenceIOR),this.iridescenceThicknessMinimum!==void 0&&(n.iridescenceThicknessMinimum=this.iridescenceThicknessMinimum),this.iridescenceThicknessMaximum!==void 0&&(n.iridescenceThicknessMaximum=this.iridescenceThicknessMaximum),this.iridescenceMap&&this.iridescenceMap.isTexture&&(n.iridescenceMap=this.iridescenceMap.toJSON(t).uuid),this.iridescenceThicknessMap&&this.iridescenceThicknessMap.isTexture&&(n.iridescenceThicknessMap=this.iridescenceThicknessMap.toJSON(t).uuid),this.anisotropy!==void 0&&(n.anisotropy=this.anisotropy),this.anisotropyRotation!==void 0&&(n.anisotropyRotation=this.anisotropyRotation),this.anisotropyMap&&this.anisotropyMap.isTexture&&(n.anisotropyMap=this.anisotropyMap.toJSON(t).uuid),this.map&&this.map.isTexture&&(n.map=this.map.toJSON(t).uuid),this.matcap&&this.matcap.isTexture&&(n.matcap=this.matcap.toJSON(t).uuid),this.alphaMap&&this.alphaMap.isTexture&&(n.alphaMap=this.alphaMap.toJSON(t).uuid),this.lightMap&&this.lightMap.isTexture&&(n.lightMap=this.lightMap.toJSON(t).uuid,n.lightMapIntensity=this.lightMapIntensity),this.aoMap&&this.aoMap.isTexture&&(n.aoMap=this.aoMap.toJSON(t).uuid,n.aoMapIntensity=this.aoMapIntensity),this.bumpMap&&this.bumpMap.isTexture&&(n.bumpMap=this.bumpMap.toJSON(t).uuid,n.bumpScale=this.bumpScale),this.normalMap&&this.normalMap.isTexture&&(n.normalMap=this.normalMap.toJSON(t).uuid,n.normalMapType=this.normalMapType,n.normalScale=this.normalScale.toArray()),this.displacementMap&&this.displacementMap.isTexture&&(n.displacementMap=this.displacementMap.toJSON(t).uuid,n.displacementScale=this.displacementScale,n.displacementBias=this.displacementBias),this.roughnessMap&&this.roughnessMap.isTexture&&(n.roughnessMap=this.roughnessMap.toJSON(t).uuid),this.metalnessMap&&this.metalnessMap.isTexture&&(n.metalnessMap=this.metalnessMap.toJSON(t).uuid),this.emissiveMap&&this.emissiveMap.isTexture&&(n.emissiveMap=this.emissiveMap.toJSON(t).uuid),this.specularMap&&this.specularMap.isTexture&&(n.specularMap=this.specularMap.toJSON(t).uuid),this.specularIntensityMap&&this.specularIntensityMap.isTexture&&(n.specularIntensityMap=this.specularIntensityMap.toJSON(t).uuid),this.specularColorMap&&this.specularColorMap.isTexture&&(n.specularColorMap=this.specularColorMap.toJSON(t).uuid),this.envMap&&this.envMap.isTexture&&(n.envMap=this.envMap.toJSON(t).uuid,this.combine!==void 0&&(n.combine=this.combine)),this.envMapRotation!==void 0&&(n.envMapRotation=this.envMapRotation.toArray()),this.envMapIntensity!==void 0&&(n.envMapIntensity=this.envMapIntensity),this.reflectivity!==void 0&&(n.reflectivity=this.reflectivity),this.refractionRatio!==void 0&&(n.refractionRatio=this.refractionRatio),this.gradientMap&&this.gradientMap.isTexture&&(n.gradientMap=this.gradientMap.toJSON(t).uuid),this.transmission!==void 0&&(n.transmission=this.transmission),this.transmissionMap&&this.transmissionMap.isTexture&&(n.transmissionMap=this.transmissionMap.toJSON(t).uuid),this.thickness!==void 0&&(n.thickness=this.thickness),this.thicknessMap&&this.thicknessMap.isTexture&&(n.thicknessMap=this.thicknessMap.toJSON(t).uuid),this.attenuationDistance!==void 0&&(n.attenuationDistance=this.attenuationDistance),this.attenuationColor!==void 0&&(n.attenuationColor=this.attenuationColor.getHex()),this.size!==void 0&&(n.size=this.size),this.sizeAttenuation!==void 0&&(n.sizeAttenuation=this.sizeAttenuation),Array.isArray(this.clippingPlanes)&&this.clippingPlanes.length>0&&(n.clippingPlanes=this.clippingPlanes.map(r=>r.toJSON())),this.rotation!==void 0&&(n.rotation=this.rotation),this.depthPacking!==void 0&&(n.depthPacking=this.depthPacking),this.linewidth!==void 0&&(n.linewidth=this.linewidth),this.linecap!==void 0&&(n.linecap=this.linecap),this.linejoin!==void 0&&(n.linejoin=this.linejoin),this.dashSize!==void 0&&(n.dashSize=this.dashSize),this.gapSize!==void 0&&(n.gapSize=this.gapSize),this.scale!==void 0&&(n.scale=this.scale),this.wireframe!==void 0&&(n.wireframe=this.wireframe),this.wireframeLinewidth!==void 0&&(n.wireframeLinewidth=this.wireframeLinewidth),this.wireframeLinecap!==void 0&&(n.wireframeLinecap=this.wireframeLinecap),this.wireframeLinejoin!==void 0&&(n.wireframeLinejoin=this.wireframeLinejoin),this.flatShading!==void 0&&(n.flatShading=this.flatShading),this.fog!==void 0&&(n.fog=this.fog),Object.keys(this.userData).length>0&&(n.userData=this.userData);function s(r){let o=[];for(let a in r){let l=r[a];delete l.metadata,o.push(l)}return o}if(e){let r=s(t.textures),o=s(t.images);r.length>0&&(n.textures=r),o.length>0&&(n.images=o)}return n}fromJSON(t,e){if(t.uuid!==void 0&&(this.uuid=t.uuid),t.name!==void 0&&(this.name=t.name),t.color!==void 0&&this.color!==void 0&&this.color.setHex(t.color),t.roughness!==void 0&&(this.roughness=t.roughness),t.metalness!==void 0&&(this.metalness=t.metalness),t.sheen!==void 0&&(this.sheen=t.sheen),t.sheenColor!==void 0&&(this.sheenColor=new Gt().setHex(t.sheenColor)),t.sheenRoughness!==void 0&&(this.sheenRoughness=t.sheenRoughness),t.emissive!==void 0&&this.emissive!==void 0&&this.emissive.setHex(t.emissive),t.specular!==void 0&&this.specular!==void 0&&this.specular.setHex(t.specular),t.specularIntensity!==void 0&&(this.specularIntensity=t.specularIntensity),t.specularColor!==void 0&&this.specularColor!==void 0&&this.specularColor.setHex(t.specularColor),t.shininess!==void 0&&(this.shininess=t.shininess),t.clearcoat!==void 0&&(this.clearcoat=t.clearcoat),t.clearcoatRoughness!==void 0&&(this.clearcoatRoughness=t.clearcoatRoughness),t.diffuseRoughness!==void 0&&(this.diffuseRoughness=t.diffuseRoughness),t.dispersion!==void 0&&(this.dispersion=t.dispersion),t.retroreflectivity!==void 0&&(this.retroreflectivity=t.retroreflectivity),t.iridescence!==void 0&&(this.iridescence=t.iridescence),t.iridescenceIOR!==void 0&&(this.iridescenceIOR=t.iridescenceIOR),t.iridescenceThicknessMinimum!==void 0&&(this.iridescenceThicknessMinimum=t.iridescenceThicknessMinimum),t.iridescenceThicknessMaximum!==void 0&&(this.iridescenceThicknessMaximum=t.iridescenceThicknessMaximum),t.iridescenceThicknessRange!==void 0&&(this.iridescenceThicknessMinimum=t.iridescenceThicknessRange[0],this.iridescenceThicknessMaximum=t.iridescenceThicknessRange[1]),t.transmission!==void 0&&(this.transmission=t.transmission),t.thickness!==void 0&&(this.thickness=t.thickness),t.attenuationDistance!==void 0&&(this.attenuationDistance=t.attenuationDistance),t.attenuationColor!==void 0&&this.attenuationColor!==void 0&&this.attenuationColor.setHex(t.attenuationColor),t.anisotropy!==void 0&&(this.anisotropy=t.anisotropy),t.anisotropyRotation!==void 0&&(this.anisotropyRotation=t.anisotropyRotation),t.fog!==void 0&&(this.fog=t.fog),t.flatShading!==void 0&&(this.flatShading=t.flatShading),t.blending!==void 0&&(this.blending=t.blending),t.combine!==void 0&&(this.combine=t.combine),t.side!==void 0&&(this.side=t.side),t.shadowSide!==void 0&&(this.shadowSide=t.shadowSide),t.opacity!==void 0&&(this.opacity=t.opacity),t.transparent!==void 0&&(this.transparent=t.transparent),t.alphaTest!==void 0&&(this.alphaTest=t.alphaTest),t.alphaHash!==void 0&&(this.alphaHash=t.alphaHash),t.depthFunc!==void 0&&(this.depthFunc=t.depthFunc),t.depthTest!==void 0&&(this.depthTest=t.depthTest),t.depthWrite!==void 0&&(this.depthWrite=t.depthWrite),t.colorWrite!==void 0&&(this.colorWrite=t.colorWrite),t.clippingPlanes!==void 0&&(this.clippingPlanes=t.clippingPlanes.map(n=>new Xe().fromJSON(n))),t.clipIntersection!==void 0&&(this.clipIntersection=t.clipIntersection),t.clipShadows!==void 0&&(this.clipShadows=t.clipShadows),t.depthPacking!==void 0&&(this.depthPacking=t.depthPacking),t.blendSrc!==void 0&&(this.blendSrc=t.blendSrc),t.blendDst!==void 0&&(this.blendDst=t.blendDst),t.blendEquation!==void 0&&(this.blendEquation=t.blendEquation),t.blendSrcAlpha!==void 0&&(this.blendSrcAlpha=t.blendSrcAlpha),t.blendDstAlpha!==void 0&&(this.blendDstAlpha=t.blendDstAlpha),t.blendEquationAlpha!==void 0&&(this.blendEquationAlpha=t.blendEquationAlpha),t.blendColor!==void 0&&this.blendColor!==void 0&&this.blendColor.setHex(t.blendColor),t.blendAlpha!==void 0&&(this.blendAlpha=t.blendAlpha),t.stencilWriteMask!==void 0&&(this.stencilWriteMask=t.stencilWriteMask),t.stencilFunc!==void 0&&(this.stencilFunc=t.stencilFunc),t.stencilRef!==void 0&&(this.stencilRef=t.stencilRef),t.stencilFuncMask!==void 0&&(this.stencilFuncMask=t.stencilFuncMask),t.stencilFail!==void 0&&(this.stencilFail=t.stencilFail),t.stencilZFail!==void 0&&(this.stencilZFail=t.stencilZFail),t.stencilZPass!==void 0&&(this.stencilZPass=t.stencilZPass),t.stencilWrite!==void 0&&(this.stencilWrite=t.stencilWrite),t.wireframe!==void 0&&(this.wireframe=t.wireframe),t.wireframeLinewidth!==void 0&&(this.wireframeLinewidth=t.wireframeLinewidth),t.wireframeLinecap!==void 0&&(this.wireframeLinecap=t.wireframeLinecap),t.wireframeLinejoin!==void 0&&(this.wireframeLinejoin=t.wireframeLinejoin),t.rotation!==void 0&&(this.rotation=t.rotation),t.linewidth!==void 0&&(this.linewidth=t.linewidth),t.linecap!==void 0&&(this.linecap=t.linecap),t.linejoin!==void 0&&(this.linejoin=t.linejoin),t.dashSize!==void 0&&(this.dashSize=t.dashSize),t.gapSize!==void 0&&(this.gapSize=t.gapSize),t.scale!==void 0&&(this.scale=t.scale),t.polygonOffset!==void 0&&(this.polygonOffset=t.polygonOffset),t.polygonOffsetFactor!==void 0&&(this.polygonOffsetFactor=t.polygonOffsetFactor),t.polygonOffsetUnits!==void 0&&(this.polygonOffsetUnits=t.polygonOffsetUnits),t.dithering!==void 0&&(this.dithering=t.dithering),t.alphaToCoverage!==void 0&&(this.alphaToCoverage=t.alphaToCoverage),t.premultipliedAlpha!==void 0&&(this.premultipliedAlpha=t.premultipliedAlpha),t.forceSinglePass!==void 0&&(this.forceSinglePass=t.forceSinglePass),t.allowOverride!==void 0&&(this.allowOverride=t.allowOverride),t.visible!==void 0&&(this.visible=t.visible),t.toneMapped!==void 0&&(this.toneMapped=t.toneMapped),t.userData!==void 0&&(this.userData=t.userData),t.vertexColors!==void 0&&(typeof t.vertexColors=="number"?this.vertexColors=t.vertexColors>0:this.vertexColors=t.vertexColors),t.size!==void 0&&(this.size=t.size),t.sizeAttenuation!==void 0&&(this.sizeAttenuation=t.sizeAttenuation),t.map!==void 0&&(this.map=e[t.map]||null),t.matcap!==void 0&&(this.matcap=e[t.matcap]||null),t.alphaMap!==void 0&&(this.alphaMap=e[t.alphaMap]||null),t.bumpMap!==void 0&&(this.bumpMap=e[t.bumpMap]||null),t.bumpScale!==void 0&&(this.bumpScale=t.bumpScale),t.normalMap!==void 0&&(this.normalMap=e[t.normalMap]||null),t.normalMapType!==void 0&&(this.normalMapType=t.normalMapType),t.normalScale!==void 0){let n=t.normalScale;Array.isArray(n)===!1&&(n=[n,n]),this.normalScale=new Ct().fromArray(n)}return t.displacementMap!==void 0&&(this.displacementMap=e[t.displacementMap]||null),t.displacementScale!==void 0&&(this.displacementScale=t.displacementScale),t.displacementBias!==void 0&&(this.displacementBias=t.displacementBias),t.roughnessMap!==void 0&&(this.roughnessMap=e[t.roughnessMap]||null),t.metalnessMap!==void 0&&(this.metalnessMap=e[t.metalnessMap]||null),t.emissiveMap!==void 0&&(this.emissiveMap=e[t.emissiveMap]||null),t.emissiveIntensity!==void 0&&(this.emissiveIntensity=t.emissiveIntensity),t.specularMap!==void 0&&(this.specularMap=e[t.specularMap]||null),t.specularIntensityMap!==void 0&&(this.specularIntensityMap=e[t.specularIntensityMap]||null),t.specularColorMap!==void 0&&(this.specularColorMap=e[t.specularColorMap]||null),t.envMap!==void 0&&(this.envMap=e[t.envMap]||null),t.envMapRotation!==void 0&&this.envMapRotation.fromArray(t.envMapRotation),t.envMapIntensity!==void 0&&(this.envMapIntensity=t.envMapIntensity),t.reflectivity!==void 0&&(this.reflectivity=t.reflectivity),t.refractionRatio!==void 0&&(this.refractionRatio=t.refractionRatio),t.lightMap!==void 0&&(this.lightMap=e[t.lightMap]||null),t.lightMapIntensity!==void 0&&(this.lightMapIntensity=t.lightMapIntensity),t.aoMap!==void 0&&(this.aoMap=e[t.aoMap]||null),t.aoMapIntensity!==void 0&&(this.aoMapIntensity=t.aoMapIntensity),t.gradientMap!==void 0&&(this.gradientMap=e[t.gradientMap]||null),t.clearcoatMap!==void 0&&(this.clearcoatMap=e[t.clearcoatMap]||null),t.clearcoatRoughnessMap!==void 0&&(this.clearcoatRoughnessMap=e[t.clearcoatRoughnessMap]||null),t.clearcoatNormalMap!==void 0&&(this.clearcoatNormalMap=e[t.clearcoatNormalMap]||null),t.clearcoatNormalScale!==void 0&&(this.clearcoatNormalScale=new Ct().fromArray(t.clearcoatNormalScale)),t.diffuseRoughnessMap!==void 0&&(this.diffuseRoughnessMap=e[t.diffuseRoughnessMap]||null),t.iridescenceMap!==void 0&&(this.iridescenceMap=e[t.iridescenceMap]||null),t.iridescenceThicknessMap!==void 0&&(this.iridescenceThicknessMap=e[t.iridescenceThicknessMap]||null),t.transmissionMap!==void 0&&(this.transmissionMap=e[t.transmissionMap]||null),t.thicknessMap!==void 0&&(this.thicknessMap=e[t.thicknessMap]||null),t.anisotropyMap!==void 0&&(this.anisotropyMap=e[t.anisotropyMap]||null),t.sheenColorMap!==void 0&&(this.sheenColorMap=e[t.sheenColorMap]||null),t.sheenRoughnessMap!==void 0&&(this.sheenRoughnessMap=e[t.sheenRoughnessMap]||null),this}clone(){return new this.constructor().copy(this)}copy(t){this.name=t.name,this.blending=t.blending,this.side=t.side,this.vertexColors=t.vertexColors,this.opacity=t.opacity,this.transparent=t.transparent,this.blendSrc=t.blendSrc,this.blendDst=t.blendDst,this.blendEquation=t.blendEquation,this.blendSrcAlpha=t.blendSrcAlpha,this.blendDstAlpha=t.blendDstAlpha,this.blendEquationAlpha=t.blendEquationAlpha,this.blendColor.copy(t.blendColor),this.blendAlpha=t.blendAlpha,this.depthFunc=t.depthFunc,this.depthTest=t.depthTest,this.depthWrite=t.depthWrite,this.stencilWriteMask=t.stencilWriteMask,this.stencilFunc=t.stencilFunc,this.stencilRef=t.stencilRef,this.stencilFuncMask=t.stencilFuncMask,this.stencilFail=t.stencilFail,this.stencilZFail=t.stencilZFail,this.stencilZPass=t.stencilZPass,this.stencilWrite=t.stencilWrite;let e=t.clippingPlanes,n=null;if(e!==null){let s=e.length;n=new Array(s);for(let r=0;r!==s;++r)n[r]=e[r].clone()}return this.clippingPlanes=n,this.clipIntersection=t.clipIntersection,this.clipShadows=t.clipShadows,this.shadowSide=t.shadowSide,this.colorWrite=t.colorWrite,this.precision=t.precision,this.polygonOffset=t.polygonOffset,this.polygonOffsetFactor=t.polygonOffsetFactor,this.polygonOffsetUnits=t.polygonOffsetUnits,this.dithering=t.dithering,this.alphaTest=t.alphaTest,this.alphaHash=t.alphaHash,this.alphaToCoverage=t.alphaToCoverage,this.premultipliedAlpha=t.premultipliedAlpha,this.forceSinglePass=t.forceSinglePass,this.allowOverride=t.allowOverride,this.visible=t.visible,this.toneMapped=t.toneMapped,this.userData=JSON.parse(JSON.stringify(t.userData)),this}dispose(){this.dispatchEvent({type:"dispose"})}set needsUpdate(t){t===!0&&this.version++}};var ci=new P,oh=new P,Do=new P,No=new P,pi=class{constructor(t=new P,e=new P(0,0,-1)){this.origin=t,this.direction=e}set(t,e){return this.origin.copy(t),this.direction.copy(e),this}copy(t){return this.origin.copy(t.origin),this.direction.copy(t.direction),this}at(t,e){return e.copy(this.origin).addScaledVector(this.direction,t)}lookAt(t){return this.direction.copy(t).sub(this.origin).normalize(),this}recast(t){return this.origin.copy(this.at(t,ci)),this}closestPointToPoint(t,e){e.subVectors(t,this.origin);let n=e.dot(this.direction);return n<0?e.copy(this.origin):e.copy(this.origin).addScaledVector(this.direction,n)}distanceToPoint(t){return Math.sqrt(this.distanceSqToPoint(t))}distanceSqToPoint(t){let e=ci.subVectors(t,this.origin).dot(this.direction);return e<0?this.origin.distanceToSquared(t):(ci.copy(this.origin).addScaledVector(this.direction,e),ci.distanceToSquared(t))}distanceSqToSegment(t,e,n,s){oh.copy(t).add(e).multiplyScalar(.5),Do.copy(e).sub(t).normalize(),No.copy(this.origin).sub(oh);let r=t.distanceTo(e)*.5,o=-this.direction.dot(Do),a=No.dot(this.direction),l=-No.dot(Do),c=No.lengthSq(),h=Math.abs(1-o*o),d,u,f,g;if(h>0)if(d=o*l-a,u=o*a-l,g=r*h,d>=0)if(u>=-g)if(u<=g){let x=1/h;d*=x,u*=x,f=d*(d+o*u+2*a)+u*(o*d+u+2*l)+c}else u=r,d=Math.max(0,-(o*u+a)),f=-d*d+u*(u+2*l)+c;else u=-r,d=Math.max(0,-(o*u+a)),f=-d*d+u*(u+2*l)+c;else u<=-g?(d=Math.max(0,-(-o*r+a)),u=d>0?-r:Math.min(Math.max(-r,-l),r),f=-d*d+u*(u+2*l)+c):u<=g?(d=0,u=Math.min(Math.max(-r,-l),r),f=u*(u+2*l)+c):(d=Math.max(0,-(o*r+a)),u=d>0?r:Math.min(Math.max(-r,-l),r),f=-d*d+u*(u+2*l)+c);else u=o>0?-r:r,d=Math.max(0,-(o*u+a)),f=-d*d+u*(u+2*l)+c;return n&&n.copy(this.origin).addScaledVector(this.direction,d),s&&s.copy(oh).addScaledVector(Do,u),f}intersectSphere(t,e){if(t.radius<0)return null;ci.subVectors(t.center,this.origin);let n=ci.dot(this.direction),s=ci.dot(ci)-n*n,r=t.radius*t.radius;if(s>r)return null;let o=Math.sqrt(r-s),a=n-o,l=n+o;return l<0?null:a<0?this.at(l,e):this.at(a,e)}intersectsSphere(t){return t.radius<0?!1:this.distanceSqToPoint(t.center)<=t.radius*t.radius}distanceToPlane(t){let e=t.normal.dot(this.direction);if(e===0)return t.distanceToPoint(this.origin)===0?0:null;let n=-(this.origin.dot(t.normal)+t.constant)/e;return n>=0?n:null}intersectPlane(t,e){let n=this.distanceToPlane(t);return n===null?null:this.at(n,e)}intersectsPlane(t){let e=t.distanceToPoint(this.origin);return e===0||t.normal.dot(this.direction)*e<0}intersectBox(t,e){let n,s,r,o,a,l,c=1/this.direction.x,h=1/this.direction.y,d=1/this.direction.z,u=this.origin;return c>=0?(n=(t.min.x-u.x)*c,s=(t.max.x-u.x)*c):(n=(t.max.x-u.x)*c,s=(t.min.x-u.x)*c),h>=0?(r=(t.min.y-u.y)*h,o=(t.max.y-u.y)*h):(r=(t.max.y-u.y)*h,o=(t.min.y-u.y)*h),n>o||r>s||((r>n||isNaN(n))&&(n=r),(o<s||isNaN(s))&&(s=o),d>=0?(a=(t.min.z-u.z)*d,l=(t.max.z-u.z)*d):(a=(t.max.z-u.z)*d,l=(t.min.z-u.z)*d),n>l||a>s)||((a>n||n!==n)&&(n=a),(l<s||s!==s)&&(s=l),s<0)?null:this.at(n>=0?n:s,e)}intersectsBox(t){return this.intersectBox(t,ci)!==null}intersectTriangle(t,e,n,s,r){let o=this.origin,a=this.direction,l=a.x,c=a.y,h=a.z,d=t.x-o.x,u=t.y-o.y,f=t.z-o.z,g=e.x-o.x,x=e.y-o.y,p=e.z-o.z,m=n.x-o.x,_=n.y-o.y,M=n.z-o.z,y=Math.abs(l),T=Math.abs(c),E=Math.abs(h),v,w,F,D,N,O,V,C,H,X,G,nt;if(y>=T&&y>=E?(F=l,O=d,H=g,nt=m,l>=0?(v=c,w=h,D=u,N=f,V=x,C=p,X=_,G=M):(v=h,w=c,D=f,N=u,V=p,C=x,X=M,G=_)):T>=E?(F=c,O=u,H=x,nt=_,c>=0?(v=h,w=l,D=f,N=d,V=p,C=g,X=M,G=m):(v=l,w=h,D=d,N=f,V=g,C=p,X=m,G=M)):(F=h,O=f,H=p,nt=M,h>=0?(v=l,w=c,D=d,N=u,V=g,C=x,X=m,G=_):(v=c,w=l,D=u,N=d,V=x,C=g,X=_,G=m)),F===0)return null;let $=v/F,Q=w/F,et=1/F,yt=D-$*O,Dt=N-Q*O,Z=V-$*H,gt=C-Q*H,bt=X-$*nt,Rt=G-Q*nt,vt=bt*gt-Rt*Z,Bt=yt*Rt-Dt*bt,xe=Z*Dt-gt*yt;if(s){if(vt<0||Bt<0||xe<0)return null}else if((vt<0||Bt<0||xe<0)&&(vt>0||Bt>0||xe>0))return null;let It=vt+Bt+xe;if(It===0)return null;let te=et*(vt*O+Bt*H+xe*nt);return(It>0?te<0:te>0)?null:this.at(te/It,r)}applyMatrix4(t){return this.origin.applyMatrix4(t),this.direction.transformDirection(t),this}equals(t){return t.origin.equals(this.origin)&&t.direction.equals(this.direction)}clone(){return new this.constructor().copy(this)}},Cn=class extends fi{constructor(t){super(),this.isMeshBasicMaterial=!0,this.type="MeshBasicMaterial",this.color=new Gt(16777215),this.map=null,this.lightMap=null,this.lightMapIntensity=1,this.aoMap=null,this.aoMapIntensity=1,this.specularMap=null,this.alphaMap=null,this.envMap=null,this.envMapRotation=new Di,this.combine=Th,this.reflectivity=1,this.refractionRatio=.98,this.wireframe=!1,this.wireframeLinewidth=1,this.wireframeLinecap="round",this.wireframeLinejoin="round",this.fog=!0,this.setValues(t)}copy(t){return super.copy(t),this.color.copy(t.color),this.map=t.map,this.lightMap=t.lightMap,this.lightMapIntensity=t.lightMapIntensity,this.aoMap=t.aoMap,this.aoMapIntensity=t.aoMapIntensity,this.specularMap=t.specularMap,this.alphaMap=t.alphaMap,this.envMap=t.envMap,this.envMapRotation.copy(t.envMapRotation),this.combine=t.combine,this.reflectivity=t.reflectivity,this.refractionRatio=t.refractionRatio,this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this.wireframeLinecap=t.wireframeLinecap,this.wireframeLinejoin=t.wireframeLinejoin,this.fog=t.fog,this}},Zd=new jt,Qi=new pi,Uo=new ln,Kd=new P,Fo=new P,Oo=new P,Bo=new P,ah=new P,ko=new P,Jd=new P,zo=new P,me=class extends an{constructor(t=new he,e=new Cn){super(),this.isMesh=!0,this.type="Mesh",this.geometry=t,this.material=e,this.morphTargetDictionary=void 0,this.morphTargetInfluences=void 0,this.count=1,this.updateMorphTargets()}copy(t,e){return super.copy(t,e),t.morphTargetInfluences!==void 0?this.morphTargetInfluences=t.morphTargetInfluences.slice():this.morphTargetInfluences=void 0,t.morphTargetDictionary!==void 0?this.morphTargetDictionary=Object.assign({},t.morphTargetDictionary):this.morphTargetDictionary=void 0,this.material=Array.isArray(t.material)?t.material.slice():t.material,this.geometry=t.geometry,this}updateMorphTargets(){let e=this.geometry.morphAttributes,n=Object.keys(e);if(n.length>0){let s=e[n[0]];if(s!==void 0){this.morphTargetInfluences=[],this.morphTargetDictionary={};for(let r=0,o=s.length;r<o;r++){let a=s[r].name||String(r);this.morphTargetInfluences.push(0),this.morphTargetDictionary[a]=r}}}}getVertexPosition(t,e){let n=this.geometry,s=n.attributes.position,r=n.morphAttributes.position,o=n.morphTargetsRelative;e.fromBufferAttribute(s,t);let a=this.morphTargetInfluences;if(r&&a){ko.set(0,0,0);for(let l=0,c=r.length;l<c;l++){let h=a[l],d=r[l];h!==0&&(ah.fromBufferAttribute(d,t),o?ko.addScaledVector(ah,h):ko.addScaledVector(ah.sub(e),h))}e.add(ko)}return e}intersectsFrustum(t){return t.intersectsObject(this)}raycast(t,e){let n=this.geometry,s=this.material,r=this.matrixWorld;s!==void 0&&(n.boundingSphere===null&&n.computeBoundingSphere(),Uo.copy(n.boundingSphere),Uo.applyMatrix4(r),Qi.copy(t.ray).recast(t.near),!(Uo.containsPoint(Qi.origin)===!1&&(Qi.intersectSphere(Uo,Kd)===null||Qi.origin.distanceToSquared(Kd)>(t.far-t.near)**2))&&(Zd.copy(r).invert(),Qi.copy(t.ray).applyMatrix4(Zd),!(n.boundingBox!==null&&Qi.intersectsBox(n.boundingBox)===!1)&&this._computeIntersections(t,e,Qi)))}_computeIntersections(t,e,n){let s,r=this.geometry,o=this.material,a=r.index,l=r.attributes.position,c=r.attributes.uv,h=r.attributes.uv1,d=r.attributes.normal,u=r.groups,f=r.drawRange;if(a!==null)if(Array.isArray(o))for(let g=0,x=u.length;g<x;g++){let p=u[g],m=o[p.materialIndex],_=Math.max(p.start,f.start),M=Math.min(a.count,Math.min(p.start+p.count,f.start+f.count));for(let y=_,T=M;y<T;y+=3){let E=a.getX(y),v=a.getX(y+1),w=a.getX(y+2);s=Ho(this,m,t,n,c,h,d,E,v,w),s&&(s.faceIndex=Math.floor(y/3),s.face.materialIndex=p.materialIndex,e.push(s))}}else{let g=Math.max(0,f.start),x=Math.min(a.count,f.start+f.count);for(let p=g,m=x;p<m;p+=3){let _=a.getX(p),M=a.getX(p+1),y=a.getX(p+2);s=Ho(this,o,t,n,c,h,d,_,M,y),s&&(s.faceIndex=Math.floor(p/3),e.push(s))}}else if(l!==void 0)if(Array.isArray(o))for(let g=0,x=u.length;g<x;g++){let p=u[g],m=o[p.materialIndex],_=Math.max(p.start,f.start),M=Math.min(l.count,Math.min(p.start+p.count,f.start+f.count));for(let y=_,T=M;y<T;y+=3){let E=y,v=y+1,w=y+2;s=Ho(this,m,t,n,c,h,d,E,v,w),s&&(s.faceIndex=Math.floor(y/3),s.face.materialIndex=p.materialIndex,e.push(s))}}else{let g=Math.max(0,f.start),x=Math.min(l.count,f.start+f.count);for(let p=g,m=x;p<m;p+=3){let _=p,M=p+1,y=p+2;s=Ho(this,o,t,n,c,h,d,_,M,y),s&&(s.faceIndex=Math.floor(p/3),e.push(s))}}}};function cv(i,t,e,n,s,r,o,a){let l;if(t.side===Ae?l=n.intersectTriangle(o,r,s,!0,a):l=n.intersectTriangle(s,r,o,t.side===zn,a),l===null)return null;zo.copy(a),zo.applyMatrix4(i.matrixWorld);let c=e.ray.origin.distanceTo(zo);return c<e.near||c>e.far?null:{distance:c,point:zo.clone(),object:i}}function Ho(i,t,e,n,s,r,o,a,l,c){i.getVertexPosition(a,Fo),i.getVertexPosition(l,Oo),i.getVertexPosition(c,Bo);let h=cv(i,t,e,n,Fo,Oo,Bo,Jd);if(h){let d=new P;Li.getBarycoord(Jd,Fo,Oo,Bo,d),s&&(h.uv=Li.getInterpolatedAttribute(s,a,l,c,d,new Ct)),r&&(h.uv1=Li.getInterpolatedAttribute(r,a,l,c,d,new Ct)),o&&(h.normal=Li.getInterpolatedAttribute(o,a,l,c,d,new P),h.normal.dot(n.direction)>0&&h.normal.multiplyScalar(-1));let u={a,b:l,c,normal:new P,materialIndex:0};Li.getNormal(Fo,Oo,Bo,u.normal),h.face=u,h.barycoord=d}return h}var Us=class extends on{constructor(t=null,e=1,n=1,s,r,o,a,l,c=Ue,h=Ue,d,u){super(null,o,a,l,c,h,s,r,d,u),this.isDataTexture=!0,this.image={data:t,width:e,height:n},this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1}};var ts=new ln,hv=new Ct(.5,.5),Go=new P,es=class{constructor(t=new Xe,e=new Xe,n=new Xe,s=new Xe,r=new Xe,o=new Xe){this.planes=[t,e,n,s,r,o]}set(t,e,n,s,r,o){let a=this.planes;return a[0].copy(t),a[1].copy(e),a[2].copy(n),a[3].copy(s),a[4].copy(r),a[5].copy(o),this}copy(t){let e=this.planes;for(let n=0;n<6;n++)e[n].copy(t.planes[n]);return this}setFromProjectionMatrix(t,e=Tn,n=!1){let s=this.planes,r=t.elements,o=r[0],a=r[1],l=r[2],c=r[3],h=r[4],d=r[5],u=r[6],f=r[7],g=r[8],x=r[9],p=r[10],m=r[11],_=r[12],M=r[13],y=r[14],T=r[15];if(s[0].setComponents(c-o,f-h,m-g,T-_).normalize(),s[1].setComponents(c+o,f+h,m+g,T+_).normalize(),s[2].setComponents(c+a,f+d,m+x,T+M).normalize(),s[3].setComponents(c-a,f-d,m-x,T-M).normalize(),n)s[4].setComponents(l,u,p,y).normalize(),s[5].setComponents(c-l,f-u,m-p,T-y).normalize();else if(s[4].setComponents(c-l,f-u,m-p,T-y).normalize(),e===Tn)s[5].setComponents(c+l,f+u,m+p,T+y).normalize();else if(e===vr)s[5].setComponents(l,u,p,y).normalize();else throw new Error("THREE.Frustum.setFromProjectionMatrix(): Invalid coordinate system: "+e);return this}intersectsObject(t){if(t.boundingSphere!==void 0)t.boundingSphere===null&&t.computeBoundingSphere(),ts.copy(t.boundingSphere).applyMatrix4(t.matrixWorld);else{let e=t.geometry;e.boundingSphere===null&&e.computeBoundingSphere(),ts.copy(e.boundingSphere).applyMatrix4(t.matrixWorld)}return this.intersectsSphere(ts)}intersectsSprite(t){ts.center.set(0,0,0);let e=hv.distanceTo(t.center);return ts.radius=.7071067811865476+e,ts.applyMatrix4(t.matrixWorld),this.intersectsSphere(ts)}intersectsSphere(t){let e=this.planes,n=t.center,s=-t.radius;for(let r=0;r<6;r++)if(e[r].distanceToPoint(n)<s)return!1;return!0}intersectsBox(t){let e=this.planes;for(let n=0;n<6;n++){let s=e[n];if(Go.x=s.normal.x>0?t.max.x:t.min.x,Go.y=s.normal.y>0?t.max.y:t.min.y,Go.z=s.normal.z>0?t.max.z:t.min.z,s.distanceToPoint(Go)<0)return!1}return!0}containsPoint(t){let e=this.planes;for(let n=0;n<6;n++)if(e[n].distanceToPoint(t)<0)return!1;return!0}clone(){return new this.constructor().copy(this)}},Qd=new jt,pa=class i{constructor(){this.coordinateSystem=Tn,this._frustums=[],this._count=0}setFromArrayCamera(t){let e=t.cameras,n=this._frustums;for(let s=0;s<e.length;s++){let r=e[s];Qd.multiplyMatrices(r.projectionMatrix,r.matrixWorldInverse),n[s]===void 0&&(n[s]=new es),n[s].setFromProjectionMatrix(Qd,r.coordinateSystem,r.reversedDepth)}return this._count=e.length,this}getFrustum(t){return this._frustums[t]}intersectsObject(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsObject(t))return!0;return!1}intersectsSprite(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsSprite(t))return!0;return!1}intersectsSphere(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsSphere(t))return!0;return!1}intersectsBox(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].intersectsBox(t))return!0;return!1}containsPoint(t){let e=this._frustums;for(let n=0;n<this._count;n++)if(e[n].containsPoint(t))return!0;return!1}copy(t){this.coordinateSystem=t.coordinateSystem;let e=this._frustums,n=t._frustums;for(let s=0;s<t._count;s++)e[s]===void 0&&(e[s]=new es),e[s].copy(n[s]);return this._count=t._count,this}clone(){return new i().copy(this)}};var mn=class extends fi{constructor(t){super(),this.isLineBasicMaterial=!0,this.type="LineBasicMaterial",this.color=new Gt(16777215),this.map=null,this.linewidth=1,this.linecap="round",this.linejoin="round",this.fog=!0,this.setValues(t)}copy(t){return super.copy(t),this.color.copy(t.color),this.map=t.map,this.linewidth=t.linewidth,this.linecap=t.linecap,this.linejoin=t.linejoin,this.fog=t.fog,this}},ma=new P,ga=new P,tf=new jt,cr=new pi,Vo=new ln,lh=new P,ef=new P,va=class extends an{constructor(t=new he,e=new mn){super(),this.isLine=!0,this.type="Line",this.geometry=t,this.material=e,this.morphTargetDictionary=void 0,this.morphTargetInfluences=void 0,this.updateMorphTargets()}copy(t,e){return super.copy(t,e),t.morphTargetInfluences!==void 0?this.morphTargetInfluences=t.morphTargetInfluences.slice():this.morphTargetInfluences=void 0,t.morphTargetDictionary!==void 0?this.morphTargetDictionary=Object.assign({},t.morphTargetDictionary):this.morphTargetDictionary=void 0,this.material=Array.isArray(t.material)?t.material.slice():t.material,this.geometry=t.geometry,this}computeLineDistances(){let t=this.geometry;if(t.index===null){let e=t.attributes.position,n=[0];for(let s=1,r=e.count;s<r;s++)ma.fromBufferAttribute(e,s-1),ga.fromBufferAttribute(e,s),n[s]=n[s-1],n[s]+=ma.distanceTo(ga);t.setAttribute("lineDistance",new Qt(n,1))}else Tt("Line.computeLineDistances(): Computation only possible with non-indexed BufferGeometry.");return this}intersectsFrustum(t){return t.intersectsObject(this)}raycast(t,e){let n=this.geometry,s=this.matrixWorld,r=t.params.Line.threshold,o=n.drawRange;if(n.boundingSphere===null&&n.computeBoundingSphere(),Vo.copy(n.boundingSphere),Vo.applyMatrix4(s),Vo.radius+=r,t.ray.intersectsSphere(Vo)===!1)return;tf.copy(s).invert(),cr.copy(t.ray).applyMatrix4(tf);let a=r/((this.scale.x+this.scale.y+this.scale.z)/3),l=a*a,c=this.isLineSegments?2:1,h=n.index,u=n.attributes.position;if(h!==null){let f=Math.max(0,o.start),g=Math.min(h.count,o.start+o.count);for(let x=f,p=g-1;x<p;x+=c){let m=h.getX(x),_=h.getX(x+1),M=Wo(this,t,cr,l,m,_,x);M&&e.push(M)}if(this.isLineLoop){let x=h.getX(g-1),p=h.getX(f),m=Wo(this,t,cr,l,x,p,g-1);m&&e.push(m)}}else{let f=Math.max(0,o.start),g=Math.min(u.count,o.start+o.count);for(let x=f,p=g-1;x<p;x+=c){let m=Wo(this,t,cr,l,x,x+1,x);m&&e.push(m)}if(this.isLineLoop){let x=Wo(this,t,cr,l,g-1,f,g-1);x&&e.push(x)}}}updateMorphTargets(){let e=this.geometry.morphAttributes,n=Object.keys(e);if(n.length>0){let s=e[n[0]];if(s!==void 0){this.morphTargetInfluences=[],this.morphTargetDictionary={};for(let r=0,o=s.length;r<o;r++){let a=s[r].name||String(r);this.morphTargetInfluences.push(0),this.morphTargetDictionary[a]=r}}}}};function Wo(i,t,e,n,s,r,o){let a=i.geometry.attributes.position;if(ma.fromBufferAttribute(a,s),ga.fromBufferAttribute(a,r),e.distanceSqToSegment(ma,ga,lh,ef)>n)return;lh.applyMatrix4(i.matrixWorld);let c=t.ray.origin.distanceTo(lh);if(!(c<t.near||c>t.far))return{distance:c,point:ef.clone().applyMatrix4(i.matrixWorld),index:o,face:null,faceIndex:null,barycoord:null,object:i}}var nf=new P,sf=new P,Rn=class extends va{constructor(t,e){super(t,e),this.isLineSegments=!0,this.type="LineSegments"}computeLineDistances(){let t=this.geometry;if(t.index===null){let e=t.attributes.position,n=[];for(let s=0,r=e.count;s<r;s+=2)nf.fromBufferAttribute(e,s),sf.fromBufferAttribute(e,s+1),n[s]=s===0?0:n[s-1],n[s+1]=n[s]+nf.distanceTo(sf);t.setAttribute("lineDistance",new Qt(n,1))}else Tt("LineSegments.computeLineDistances(): Computation only possible with non-indexed BufferGeometry.");return this}};var Pn=class extends fi{constructor(t){super(),this.isPointsMaterial=!0,this.type="PointsMaterial",this.color=new Gt(16777215),this.map=null,this.alphaMap=null,this.size=1,this.sizeAttenuation=!0,this.fog=!0,this.setValues(t)}copy(t){return super.copy(t),this.color.copy(t.color),this.map=t.map,this.alphaMap=t.alphaMap,this.size=t.size,this.sizeAttenuation=t.sizeAttenuation,this.fog=t.fog,this}},rf=new jt,ph=new pi,$o=new ln,Xo=new P,In=class extends an{constructor(t=new he,e=new Pn){super(),this.isPoints=!0,this.type="Points",this.geometry=t,this.material=e,this.morphTargetDictionary=void 0,this.morphTargetInfluences=void 0,this.updateMorphTargets()}copy(t,e){return super.copy(t,e),t.morphTargetInfluences!==void 0?this.morphTargetInfluences=t.morphTargetInfluences.slice():this.morphTargetInfluences=void 0,t.morphTargetDictionary!==void 0?this.morphTargetDictionary=Object.assign({},t.morphTargetDictionary):this.morphTargetDictionary=void 0,this.material=Array.isArray(t.material)?t.material.slice():t.material,this.geometry=t.geometry,this}intersectsFrustum(t){return t.intersectsObject(this)}raycast(t,e){let n=this.geometry,s=this.matrixWorld,r=t.params.Points.threshold,o=n.drawRange;if(n.boundingSphere===null&&n.computeBoundingSphere(),$o.copy(n.boundingSphere),$o.applyMatrix4(s),$o.radius+=r,t.ray.intersectsSphere($o)===!1)return;rf.copy(s).invert(),ph.copy(t.ray).applyMatrix4(rf);let a=r/((this.scale.x+this.scale.y+this.scale.z)/3),l=a*a,c=n.index,d=n.attributes.position;if(c!==null){let u=Math.max(0,o.start),f=Math.min(c.count,o.start+o.count);for(let g=u,x=f;g<x;g++){let p=c.getX(g);Xo.fromBufferAttribute(d,p),of(Xo,p,l,s,t,e,this)}}else{let u=Math.max(0,o.start),f=Math.min(d.count,o.start+o.count);for(let g=u,x=f;g<x;g++)Xo.fromBufferAttribute(d,g),of(Xo,g,l,s,t,e,this)}}updateMorphTargets(){let e=this.geometry.morphAttributes,n=Object.keys(e);if(n.length>0){let s=e[n[0]];if(s!==void 0){this.morphTargetInfluences=[],this.morphTargetDictionary={};for(let r=0,o=s.length;r<o;r++){let a=s[r].name||String(r);this.morphTargetInfluences.push(0),this.morphTargetDictionary[a]=r}}}}};function of(i,t,e,n,s,r,o){let a=ph.distanceSqToPoint(i);if(a<e){let l=new P;ph.closestPointToPoint(i,l),l.applyMatrix4(n);let c=s.ray.origin.distanceTo(l);if(c<s.near||c>s.far)return;r.push({distance:c,distanceToRay:Math.sqrt(a),point:l,index:t,face:null,faceIndex:null,barycoord:null,object:o})}}var wr=class extends on{constructor(t=[],e=rs,n,s,r,o,a,l,c,h){super(t,e,n,s,r,o,a,l,c,h),this.isCubeTexture=!0,this.flipY=!1}get images(){return this.image}set images(t){this.image=t}};var mi=class extends on{constructor(t,e,n=Hn,s,r,o,a=Ue,l=Ue,c,h=di,d=1){if(h!==di&&h!==vi)throw new Error("THREE.DepthTexture: format must be either THREE.DepthFormat or THREE.DepthStencilFormat");let u={width:t,height:e,depth:d};super(u,s,r,o,a,l,h,n,c),this.isDepthTexture=!0,this.flipY=!1,this.generateMipmaps=!1,this.compareFunction=null}copy(t){return super.copy(t),this.source=new Is(Object.assign({},t.image)),this.compareFunction=t.compareFunction,this}toJSON(t){let e=super.toJSON(t);return e.compareFunction=this.compareFunction,e}},Er=class extends mi{constructor(t,e=Hn,n=rs,s,r,o=Ue,a=Ue,l,c=di){let h={width:t,height:t,depth:1},d=[h,h,h,h,h,h];super(t,t,e,n,s,r,o,a,l,c),this.image=d,this.isCubeDepthTexture=!0,this.isCubeTexture=!0}get images(){return this.image}set images(t){this.image=t}},Ar=class extends on{constructor(t=null){super(),this.sourceTexture=t,this.isExternalTexture=!0}copy(t){return super.copy(t),this.sourceTexture=t.sourceTexture,this}},Fs=class i extends he{constructor(t=1,e=1,n=1,s=1,r=1,o=1){super(),this.type="BoxGeometry",this.parameters={width:t,height:e,depth:n,widthSegments:s,heightSegments:r,depthSegments:o};let a=this;s=Math.floor(s),r=Math.floor(r),o=Math.floor(o);let l=[],c=[],h=[],d=[],u=0,f=0;g("z","y","x",-1,-1,n,e,t,o,r,0),g("z","y","x",1,-1,n,e,-t,o,r,1),g("x","z","y",1,1,t,n,e,s,o,2),g("x","z","y",1,-1,t,n,-e,s,o,3),g("x","y","z",1,-1,t,e,n,s,r,4),g("x","y","z",-1,-1,t,e,-n,s,r,5),this.setIndex(l),this.setAttribute("position",new Qt(c,3)),this.setAttribute("normal",new Qt(h,3)),this.setAttribute("uv",new Qt(d,2));function g(x,p,m,_,M,y,T,E,v,w,F){let D=y/v,N=T/w,O=y/2,V=T/2,C=E/2,H=v+1,X=w+1,G=0,nt=0,$=new P;for(let Q=0;Q<X;Q++){let et=Q*N-V;for(let yt=0;yt<H;yt++){let Dt=yt*D-O;$[x]=Dt*_,$[p]=et*M,$[m]=C,c.push($.x,$.y,$.z),$[x]=0,$[p]=0,$[m]=E>0?1:-1,h.push($.x,$.y,$.z),d.push(yt/v),d.push(1-Q/w),G+=1}}for(let Q=0;Q<w;Q++)for(let et=0;et<v;et++){let yt=u+et+H*Q,Dt=u+et+H*(Q+1),Z=u+(et+1)+H*(Q+1),gt=u+(et+1)+H*Q;l.push(yt,Dt,gt),l.push(Dt,Z,gt),nt+=6}a.addGroup(f,nt,F),f+=nt,u+=G}}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new i(t.width,t.height,t.depth,t.widthSegments,t.heightSegments,t.depthSegments)}};function uv(i,t,e=2){let n=t&&t.length,s=n?t[0]*e:i.length,r=np(i,0,s,e,!0),o=[];if(!r||r.next===r.prev)return o;let a,l,c;if(n&&(r=gv(i,t,r,e)),i.length>80*e){a=i[0],l=i[1];let h=a,d=l;for(let u=e;u<s;u+=e){let f=i[u],g=i[u+1];f<a&&(a=f),g<l&&(l=g),f>h&&(h=f),g>d&&(d=g)}c=Math.max(h-a,d-l),c=c!==0?32767/c:0}return Tr(r,o,e,a,l,c,0),o}function np(i,t,e,n,s){let r;if(s===Tv(i,t,e,n)>0)for(let o=t;o<e;o+=n)r=af(o/n|0,i[o],i[o+1],r);else for(let o=e-n;o>=t;o-=n)r=af(o/n|0,i[o],i[o+1],r);return r&&Os(r,r.next)&&(Rr(r),r=r.next),r}function ns(i,t){if(!i)return i;t||(t=i);let e=i,n;do if(n=!1,!e.steiner&&(Os(e,e.next)||pe(e.prev,e,e.next)===0)){if(Rr(e),e=t=e.prev,e===e.next)break;n=!0}else e=e.next;while(n||e!==t);return t}function Tr(i,t,e,n,s,r,o){if(!i)return;!o&&r&&bv(i,n,s,r);let a=i;for(;i.prev!==i.next;){let l=i.prev,c=i.next;if(r?fv(i,n,s,r):dv(i)){t.push(l.i,i.i,c.i),Rr(i),i=c.next,a=c.next;continue}if(i=c,i===a){o?o===1?(i=pv(ns(i),t),Tr(i,t,e,n,s,r,2)):o===2&&mv(i,t,e,n,s,r):Tr(ns(i),t,e,n,s,r,1);break}}}function dv(i){let t=i.prev,e=i,n=i.next;if(pe(t,e,n)>=0)return!1;let s=t.x,r=e.x,o=n.x,a=t.y,l=e.y,c=n.y,h=Math.min(s,r,o),d=Math.min(a,l,c),u=Math.max(s,r,o),f=Math.max(a,l,c),g=n.next;for(;g!==t;){if(g.x>=h&&g.x<=u&&g.y>=d&&g.y<=f&&hr(s,a,r,l,o,c,g.x,g.y)&&pe(g.prev,g,g.next)>=0)return!1;g=g.next}return!0}function fv(i,t,e,n){let s=i.prev,r=i,o=i.next;if(pe(s,r,o)>=0)return!1;let a=s.x,l=r.x,c=o.x,h=s.y,d=r.y,u=o.y,f=Math.min(a,l,c),g=Math.min(h,d,u),x=Math.max(a,l,c),p=Math.max(h,d,u),m=mh(f,g,t,e,n),_=mh(x,p,t,e,n),M=i.prevZ,y=i.nextZ;for(;M&&M.z>=m&&y&&y.z<=_;){if(M.x>=f&&M.x<=x&&M.y>=g&&M.y<=p&&M!==s&&M!==o&&hr(a,h,l,d,c,u,M.x,M.y)&&pe(M.prev,M,M.next)>=0||(M=M.prevZ,y.x>=f&&y.x<=x&&y.y>=g&&y.y<=p&&y!==s&&y!==o&&hr(a,h,l,d,c,u,y.x,y.y)&&pe(y.prev,y,y.next)>=0))return!1;y=y.nextZ}for(;M&&M.z>=m;){if(M.x>=f&&M.x<=x&&M.y>=g&&M.y<=p&&M!==s&&M!==o&&hr(a,h,l,d,c,u,M.x,M.y)&&pe(M.prev,M,M.next)>=0)return!1;M=M.prevZ}for(;y&&y.z<=_;){if(y.x>=f&&y.x<=x&&y.y>=g&&y.y<=p&&y!==s&&y!==o&&hr(a,h,l,d,c,u,y.x,y.y)&&pe(y.prev,y,y.next)>=0)return!1;y=y.nextZ}return!0}function pv(i,t){let e=i;do{let n=e.prev,s=e.next.next;!Os(n,s)&&sp(n,e,e.next,s)&&Cr(n,s)&&Cr(s,n)&&(t.push(n.i,e.i,s.i),Rr(e),Rr(e.next),e=i=s),e=e.next}while(e!==i);return ns(e)}function mv(i,t,e,n,s,r){let o=i;do{let a=o.next.next;for(;a!==o.prev;){if(o.i!==a.i&&wv(o,a)){let l=rp(o,a);o=ns(o,o.next),l=ns(l,l.next),Tr(o,t,e,n,s,r,0),Tr(l,t,e,n,s,r,0);return}a=a.next}o=o.next}while(o!==i)}function gv(i,t,e,n){let s=[];for(let r=0,o=t.length;r<o;r++){let a=t[r]*n,l=r<o-1?t[r+1]*n:i.length,c=np(i,a,l,n,!1);c===c.next&&(c.steiner=!0),s.push(Mv(c))}s.sort(vv);for(let r=0;r<s.length;r++)e=xv(s[r],e);return e}function vv(i,t){let e=i.x-t.x;if(e===0&&(e=i.y-t.y,e===0)){let n=(i.next.y-i.y)/(i.next.x-i.x),s=(t.next.y-t.y)/(t.next.x-t.x);e=n-s}return e}function xv(i,t){let e=_v(i,t);if(!e)return t;let n=rp(e,i);return ns(n,n.next),ns(e,e.next)}function _v(i,t){let e=t,n=i.x,s=i.y,r=-1/0,o;if(Os(i,e))return e;do{if(Os(i,e.next))return e.next;if(s<=e.y&&s>=e.next.y&&e.next.y!==e.y){let d=e.x+(s-e.y)*(e.next.x-e.x)/(e.next.y-e.y);if(d<=n&&d>r&&(r=d,o=e.x<e.next.x?e:e.next,d===n))return o}e=e.next}while(e!==t);if(!o)return null;let a=o,l=o.x,c=o.y,h=1/0;e=o;do{if(n>=e.x&&e.x>=l&&n!==e.x&&ip(s<c?n:r,s,l,c,s<c?r:n,s,e.x,e.y)){let d=Math.abs(s-e.y)/(n-e.x);Cr(e,i)&&(d<h||d===h&&(e.x>o.x||e.x===o.x&&yv(o,e)))&&(o=e,h=d)}e=e.next}while(e!==a);return o}function yv(i,t){return pe(i.prev,i,t.prev)<0&&pe(t.next,i,i.next)<0}function bv(i,t,e,n){let s=i;do s.z===0&&(s.z=mh(s.x,s.y,t,e,n)),s.prevZ=s.prev,s.nextZ=s.next,s=s.next;while(s!==i);s.prevZ.nextZ=null,s.prevZ=null,Sv(s)}function Sv(i){let t,e=1;do{let n=i,s;i=null;let r=null;for(t=0;n;){t++;let o=n,a=0;for(let c=0;c<e&&(a++,o=o.nextZ,!!o);c++);let l=e;for(;a>0||l>0&&o;)a!==0&&(l===0||!o||n.z<=o.z)?(s=n,n=n.nextZ,a--):(s=o,o=o.nextZ,l--),r?r.nextZ=s:i=s,s.prevZ=r,r=s;n=o}r.nextZ=null,e*=2}while(t>1);return i}function mh(i,t,e,n,s){return i=(i-e)*s|0,t=(t-n)*s|0,i=(i|i<<8)&16711935,i=(i|i<<4)&252645135,i=(i|i<<2)&858993459,i=(i|i<<1)&1431655765,t=(t|t<<8)&16711935,t=(t|t<<4)&252645135,t=(t|t<<2)&858993459,t=(t|t<<1)&1431655765,i|t<<1}function Mv(i){let t=i,e=i;do(t.x<e.x||t.x===e.x&&t.y<e.y)&&(e=t),t=t.next;while(t!==i);return e}function ip(i,t,e,n,s,r,o,a){return(s-o)*(t-a)>=(i-o)*(r-a)&&(i-o)*(n-a)>=(e-o)*(t-a)&&(e-o)*(r-a)>=(s-o)*(n-a)}function hr(i,t,e,n,s,r,o,a){return!(i===o&&t===a)&&ip(i,t,e,n,s,r,o,a)}function wv(i,t){return i.next.i!==t.i&&i.prev.i!==t.i&&!Ev(i,t)&&(Cr(i,t)&&Cr(t,i)&&Av(i,t)&&(pe(i.prev,i,t.prev)||pe(i,t.prev,t))||Os(i,t)&&pe(i.prev,i,i.next)>0&&pe(t.prev,t,t.next)>0)}function pe(i,t,e){return(t.y-i.y)*(e.x-t.x)-(t.x-i.x)*(e.y-t.y)}function Os(i,t){return i.x===t.x&&i.y===t.y}function sp(i,t,e,n){let s=Yo(pe(i,t,e)),r=Yo(pe(i,t,n)),o=Yo(pe(e,n,i)),a=Yo(pe(e,n,t));return!!(s!==r&&o!==a||s===0&&qo(i,e,t)||r===0&&qo(i,n,t)||o===0&&qo(e,i,n)||a===0&&qo(e,t,n))}function qo(i,t,e){return t.x<=Math.max(i.x,e.x)&&t.x>=Math.min(i.x,e.x)&&t.y<=Math.max(i.y,e.y)&&t.y>=Math.min(i.y,e.y)}function Yo(i){return i>0?1:i<0?-1:0}function Ev(i,t){let e=i;do{if(e.i!==i.i&&e.next.i!==i.i&&e.i!==t.i&&e.next.i!==t.i&&sp(e,e.next,i,t))return!0;e=e.next}while(e!==i);return!1}function Cr(i,t){return pe(i.prev,i,i.next)<0?pe(i,t,i.next)>=0&&pe(i,i.prev,t)>=0:pe(i,t,i.prev)<0||pe(i,i.next,t)<0}function Av(i,t){let e=i,n=!1,s=(i.x+t.x)/2,r=(i.y+t.y)/2;do e.y>r!=e.next.y>r&&e.next.y!==e.y&&s<(e.next.x-e.x)*(r-e.y)/(e.next.y-e.y)+e.x&&(n=!n),e=e.next;while(e!==i);return n}function rp(i,t){let e=gh(i.i,i.x,i.y),n=gh(t.i,t.x,t.y),s=i.next,r=t.prev;return i.next=t,t.prev=i,e.next=s,s.prev=e,n.next=e,e.prev=n,r.next=n,n.prev=r,n}function af(i,t,e,n){let s=gh(i,t,e);return n?(s.next=n.next,s.prev=n,n.next.prev=s,n.next=s):(s.prev=s,s.next=s),s}function Rr(i){i.next.prev=i.prev,i.prev.next=i.next,i.prevZ&&(i.prevZ.nextZ=i.nextZ),i.nextZ&&(i.nextZ.prevZ=i.prevZ)}function gh(i,t,e){return{i,x:t,y:e,prev:null,next:null,z:0,prevZ:null,nextZ:null,steiner:!1}}function Tv(i,t,e,n){let s=0;for(let r=t,o=e-n;r<e;r+=n)s+=(i[o]-i[r])*(i[r+1]+i[o+1]),o=r;return s}var vh=class{static triangulate(t,e,n=2){return uv(t,e,n)}},Pr=class i{static area(t){let e=t.length,n=0;for(let s=e-1,r=0;r<e;s=r++)n+=t[s].x*t[r].y-t[r].x*t[s].y;return n*.5}static isClockWise(t){return i.area(t)<0}static triangulateShape(t,e){let n=[],s=[],r=[];lf(t),cf(n,t);let o=t.length;e.forEach(lf);for(let l=0;l<e.length;l++)s.push(o),o+=e[l].length,cf(n,e[l]);let a=vh.triangulate(n,s);for(let l=0;l<a.length;l+=3)r.push(a.slice(l,l+3));return r}};function lf(i){let t=i.length;t>2&&i[t-1].equals(i[0])&&i.pop()}function cf(i,t){for(let e=0;e<t.length;e++)i.push(t[e].x),i.push(t[e].y)}var Ir=class i extends he{constructor(t=1,e=1,n=1,s=1){super(),this.type="PlaneGeometry",this.parameters={width:t,height:e,widthSegments:n,heightSegments:s};let r=t/2,o=e/2,a=Math.floor(n),l=Math.floor(s),c=a+1,h=l+1,d=t/a,u=e/l,f=[],g=[],x=[],p=[];for(let m=0;m<h;m++){let _=m*u-o;for(let M=0;M<c;M++){let y=M*d-r;g.push(y,-_,0),x.push(0,0,1),p.push(M/a),p.push(1-m/l)}}for(let m=0;m<l;m++)for(let _=0;_<a;_++){let M=_+c*m,y=_+c*(m+1),T=_+1+c*(m+1),E=_+1+c*m;f.push(M,y,E),f.push(y,T,E)}this.setIndex(f),this.setAttribute("position",new Qt(g,3)),this.setAttribute("normal",new Qt(x,3)),this.setAttribute("uv",new Qt(p,2))}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new i(t.width,t.height,t.widthSegments,t.heightSegments)}};var Lr=class extends he{constructor(t=null){if(super(),this.type="WireframeGeometry",this.parameters={geometry:t},t!==null){let e=[],n=new Set,s=new P,r=new P;if(t.index!==null){let o=t.attributes.position,a=t.index,l=t.groups;l.length===0&&(l=[{start:0,count:a.count,materialIndex:0}]);for(let c=0,h=l.length;c<h;++c){let d=l[c],u=d.start,f=d.count;for(let g=u,x=u+f;g<x;g+=3)for(let p=0;p<3;p++){let m=a.getX(g+p),_=a.getX(g+(p+1)%3);s.fromBufferAttribute(o,m),r.fromBufferAttribute(o,_),hf(s,r,n)===!0&&(e.push(s.x,s.y,s.z),e.push(r.x,r.y,r.z))}}}else{let o=t.attributes.position;for(let a=0,l=o.count/3;a<l;a++)for(let c=0;c<3;c++){let h=3*a+c,d=3*a+(c+1)%3;s.fromBufferAttribute(o,h),r.fromBufferAttribute(o,d),hf(s,r,n)===!0&&(e.push(s.x,s.y,s.z),e.push(r.x,r.y,r.z))}}this.setAttribute("position",new Qt(e,3))}}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}};function hf(i,t,e){let n=`${i.x},${i.y},${i.z}-${t.x},${t.y},${t.z}`,s=`${t.x},${t.y},${t.z}-${i.x},${i.y},${i.z}`;return e.has(n)===!0||e.has(s)===!0?!1:(e.add(n),e.add(s),!0)}function as(i){let t={};for(let e in i){t[e]={};for(let n in i[e]){let s=i[e][n];if(uf(s))s.isRenderTargetTexture?(Tt("UniformsUtils: Textures of render targets cannot be cloned via cloneUniforms() or mergeUniforms()."),t[e][n]=null):t[e][n]=s.clone();else if(Array.isArray(s))if(uf(s[0])){let r=[];for(let o=0,a=s.length;o<a;o++)r[o]=s[o].clone();t[e][n]=r}else t[e][n]=s.slice();else t[e][n]=s}}return t}function Ye(i){let t={};for(let e=0;e<i.length;e++){let n=as(i[e]);for(let s in n)t[s]=n[s]}return t}function uf(i){return i&&(i.isColor||i.isMatrix3||i.isMatrix4||i.isVector2||i.isVector3||i.isVector4||i.isTexture||i.isQuaternion)}function Cv(i){let t=[];for(let e=0;e<i.length;e++)t.push(i[e].clone());return t}function nu(i){let t=i.getRenderTarget();return t===null?i.outputColorSpace:t.isXRRenderTarget===!0?t.texture.colorSpace:Xt.workingColorSpace}var qr={clone:as,merge:Ye},Rv=`void main() {
	gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 );
}`,Pv=`void main() {
	gl_FragColor = vec4( 1.0, 0.0, 0.0, 1.0 );
}`,Ln=class extends fi{constructor(t){super(),this.isShaderMaterial=!0,this.type="ShaderMaterial",this.defines={},this.uniforms={},this.uniformsGroups=[],this.vertexShader=Rv,this.fragmentShader=Pv,this.linewidth=1,this.wireframe=!1,this.wireframeLinewidth=1,this.fog=!1,this.lights=!1,this.clipping=!1,this.forceSinglePass=!0,this.extensions={clipCullDistance:!1,multiDraw:!1},this.defaultAttributeValues={color:[1,1,1],uv:[0,0],uv1:[0,0]},this.index0AttributeName=void 0,this.uniformsNeedUpdate=!1,this.glslVersion=null,t!==void 0&&this.setValues(t)}copy(t){return super.copy(t),this.fragmentShader=t.fragmentShader,this.vertexShader=t.vertexShader,this.uniforms=as(t.uniforms),this.uniformsGroups=Cv(t.uniformsGroups),this.defines=Object.assign({},t.defines),this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this.fog=t.fog,this.lights=t.lights,this.clipping=t.clipping,this.extensions=Object.assign({},t.extensions),this.glslVersion=t.glslVersion,this.defaultAttributeValues=Object.assign({},t.defaultAttributeValues),this.index0AttributeName=t.index0AttributeName,this.uniformsNeedUpdate=t.uniformsNeedUpdate,this}toJSON(t){let e=super.toJSON(t);e.glslVersion=this.glslVersion,e.uniforms={};for(let s in this.uniforms){let o=this.uniforms[s].value;o&&o.isTexture?e.uniforms[s]={type:"t",value:o.toJSON(t).uuid}:o&&o.isColor?e.uniforms[s]={type:"c",value:o.getHex()}:o&&o.isVector2?e.uniforms[s]={type:"v2",value:o.toArray()}:o&&o.isVector3?e.uniforms[s]={type:"v3",value:o.toArray()}:o&&o.isVector4?e.uniforms[s]={type:"v4",value:o.toArray()}:o&&o.isMatrix3?e.uniforms[s]={type:"m3",value:o.toArray()}:o&&o.isMatrix4?e.uniforms[s]={type:"m4",value:o.toArray()}:e.uniforms[s]={value:o}}Object.keys(this.defines).length>0&&(e.defines=this.defines),e.vertexShader=this.vertexShader,e.fragmentShader=this.fragmentShader,e.lights=this.lights,e.clipping=this.clipping;let n={};for(let s in this.extensions)this.extensions[s]===!0&&(n[s]=!0);return Object.keys(n).length>0&&(e.extensions=n),e}fromJSON(t,e){if(super.fromJSON(t,e),t.uniforms!==void 0)for(let n in t.uniforms){let s=t.uniforms[n];switch(this.uniforms[n]={},s.type){case"t":this.uniforms[n].value=e[s.value]||null;break;case"c":this.uniforms[n].value=new Gt().setHex(s.value);break;case"v2":this.uniforms[n].value=new Ct().fromArray(s.value);break;case"v3":this.uniforms[n].value=new P().fromArray(s.value);break;case"v4":this.uniforms[n].value=new ne().fromArray(s.value);break;case"m3":this.uniforms[n].value=new Nt().fromArray(s.value);break;case"m4":this.uniforms[n].value=new jt().fromArray(s.value);break;default:this.uniforms[n].value=s.value}}if(t.defines!==void 0&&(this.defines=t.defines),t.vertexShader!==void 0&&(this.vertexShader=t.vertexShader),t.fragmentShader!==void 0&&(this.fragmentShader=t.fragmentShader),t.glslVersion!==void 0&&(this.glslVersion=t.glslVersion),t.extensions!==void 0)for(let n in t.extensions)this.extensions[n]=t.extensions[n];return t.lights!==void 0&&(this.lights=t.lights),t.clipping!==void 0&&(this.clipping=t.clipping),this}},xa=class extends Ln{constructor(t){super(t),this.isRawShaderMaterial=!0,this.type="RawShaderMaterial"}};var _a=class extends fi{constructor(t){super(),this.isMeshDepthMaterial=!0,this.type="MeshDepthMaterial",this.depthPacking=Vf,this.map=null,this.alphaMap=null,this.displacementMap=null,this.displacementScale=1,this.displacementBias=0,this.wireframe=!1,this.wireframeLinewidth=1,this.setValues(t)}copy(t){return super.copy(t),this.depthPacking=t.depthPacking,this.map=t.map,this.alphaMap=t.alphaMap,this.displacementMap=t.displacementMap,this.displacementScale=t.displacementScale,this.displacementBias=t.displacementBias,this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this}},ya=class extends fi{constructor(t){super(),this.isMeshDistanceMaterial=!0,this.type="MeshDistanceMaterial",this.map=null,this.alphaMap=null,this.displacementMap=null,this.displacementScale=1,this.displacementBias=0,this.setValues(t)}copy(t){return super.copy(t),this.map=t.map,this.alphaMap=t.alphaMap,this.displacementMap=t.displacementMap,this.displacementScale=t.displacementScale,this.displacementBias=t.displacementBias,this}};function bs(i,t){return!i||i.constructor===t?i:typeof t.BYTES_PER_ELEMENT=="number"?new t(i):Array.prototype.slice.call(i)}function jo(i){return i!==void 0&&i.inTangents!==void 0&&i.outTangents!==void 0}var Ni=class{constructor(t,e,n,s){this.parameterPositions=t,this._cachedIndex=0,this.resultBuffer=s!==void 0?s:new e.constructor(n),this.sampleValues=e,this.valueSize=n,this.settings=null,this.DefaultSettings_={}}evaluate(t){let e=this.parameterPositions,n=this._cachedIndex,s=e[n],r=e[n-1];n:{t:{let o;e:{i:if(!(t<s)){for(let a=n+2;;){if(s===void 0){if(t<r)break i;return n=e.length,this._cachedIndex=n,this.copySampleValue_(n-1)}if(n===a)break;if(r=s,s=e[++n],t<s)break t}o=e.length;break e}if(!(t>=r)){let a=e[1];t<a&&(n=2,r=a);for(let l=n-2;;){if(r===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(n===l)break;if(s=r,r=e[--n-1],t>=r)break t}o=n,n=0;break e}break n}for(;n<o;){let a=n+o>>>1;t<e[a]?o=a:n=a+1}if(s=e[n],r=e[n-1],r===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(s===void 0)return n=e.length,this._cachedIndex=n,this.copySampleValue_(n-1)}this._cachedIndex=n,this.intervalChanged_(n,r,s)}return this.interpolate_(n,r,t,s)}getSettings_(){return this.settings||this.DefaultSettings_}copySampleValue_(t){let e=this.resultBuffer,n=this.sampleValues,s=this.valueSize,r=t*s;for(let o=0;o!==s;++o)e[o]=n[r+o];return e}interpolate_(){throw new Error("THREE.Interpolant: Call to abstract method.")}intervalChanged_(){}},ba=class extends Ni{constructor(t,e,n,s){super(t,e,n,s),this._weightPrev=-0,this._offsetPrev=-0,this._weightNext=-0,this._offsetNext=-0,this.DefaultSettings_={endingStart:uh,endingEnd:uh}}intervalChanged_(t,e,n){let s=this.parameterPositions,r=t-2,o=t+1,a=s[r],l=s[o];if(a===void 0)switch(this.getSettings_().endingStart){case dh:r=t,a=2*e-n;break;case fh:r=s.length-2,a=e+s[r]-s[r+1];break;default:r=t,a=n}if(l===void 0)switch(this.getSettings_().endingEnd){case dh:o=t,l=2*n-e;break;case fh:o=1,l=n+s[1]-s[0];break;default:o=t-1,l=e}let c=(n-e)*.5,h=this.valueSize;this._weightPrev=c/(e-a),this._weightNext=c/(l-n),this._offsetPrev=r*h,this._offsetNext=o*h}interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=t*a,c=l-a,h=this._offsetPrev,d=this._offsetNext,u=this._weightPrev,f=this._weightNext,g=(n-e)/(s-e),x=g*g,p=x*g,m=-u*p+2*u*x-u*g,_=(1+u)*p+(-1.5-2*u)*x+(-.5+u)*g+1,M=(-1-f)*p+(1.5+f)*x+.5*g,y=f*p-f*x;for(let T=0;T!==a;++T)r[T]=m*o[h+T]+_*o[c+T]+M*o[l+T]+y*o[d+T];return r}},Sa=class extends Ni{constructor(t,e,n,s){super(t,e,n,s)}interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=t*a,c=l-a,h=(n-e)/(s-e),d=1-h;for(let u=0;u!==a;++u)r[u]=o[c+u]*d+o[l+u]*h;return r}},Ma=class extends Ni{constructor(t,e,n,s){super(t,e,n,s)}interpolate_(t){return this.copySampleValue_(t-1)}},wa=class extends Ni{interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=t*a,c=l-a,h=this.inTangents,d=this.outTangents;if(!h||!d){let g=(n-e)/(s-e),x=1-g;for(let p=0;p!==a;++p)r[p]=o[c+p]*x+o[l+p]*g;return r}let u=a*2,f=t-1;for(let g=0;g!==a;++g){let x=o[c+g],p=o[l+g],m=f*u+g*2,_=d[m],M=d[m+1],y=t*u+g*2,T=h[y],E=h[y+1],v=Lv(n,e,_,T,s);r[g]=op(v,x,M,E,p)}return r}};function op(i,t,e,n,s){let r=1-i;return r*r*r*t+3*r*r*i*e+3*r*i*i*n+i*i*i*s}function Iv(i,t,e,n,s){let r=1-i;return 3*r*r*(e-t)+6*r*i*(n-e)+3*i*i*(s-n)}function Lv(i,t,e,n,s){let r=(i-t)/(s-t);for(let o=0;o<8;o++){let a=op(r,t,e,n,s)-i;if(Math.abs(a)<1e-10)break;let l=Iv(r,t,e,n,s);if(Math.abs(l)<1e-10)break;r=Math.max(0,Math.min(1,r-a/l))}return r}var gn=class{constructor(t,e,n,s){if(t===void 0)throw new Error("THREE.KeyframeTrack: track name is undefined");if(e===void 0||e.length===0)throw new Error("THREE.KeyframeTrack: no keyframes in track named "+t);this.name=t,this.times=bs(e,this.TimeBufferType),this.values=bs(n,this.ValueBufferType),this.setInterpolation(s||this.DefaultInterpolation)}static toJSON(t){let e=t.constructor,n;if(e.toJSON!==this.toJSON)n=e.toJSON(t);else{n={name:t.name,times:bs(t.times,Array),values:bs(t.values,Array)};let s=t.getInterpolation();s!==t.DefaultInterpolation&&(n.interpolation=s),jo(t.settings)&&(n.settings={inTangents:bs(t.settings.inTangents,Array),outTangents:bs(t.settings.outTangents,Array)})}return n.type=t.ValueTypeName,n}InterpolantFactoryMethodDiscrete(t){return new Ma(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodLinear(t){return new Sa(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodSmooth(t){return new ba(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodBezier(t){let e=new wa(this.times,this.values,this.getValueSize(),t);return this.settings&&(e.inTangents=this.settings.inTangents,e.outTangents=this.settings.outTangents),e}setInterpolation(t){let e;switch(t){case pr:e=this.InterpolantFactoryMethodDiscrete;break;case ca:e=this.InterpolantFactoryMethodLinear;break;case Qo:e=this.InterpolantFactoryMethodSmooth;break;case hh:e=this.InterpolantFactoryMethodBezier;break}if(e===void 0){let n="unsupported interpolation for "+this.ValueTypeName+" keyframe track named "+this.name;if(this.createInterpolant===void 0)if(t!==this.DefaultInterpolation)this.setInterpolation(this.DefaultInterpolation);else throw new Error(n);return Tt("KeyframeTrack:",n),this}return this.createInterpolant=e,this}getInterpolation(){switch(this.createInterpolant){case this.InterpolantFactoryMethodDiscrete:return pr;case this.InterpolantFactoryMethodLinear:return ca;case this.InterpolantFactoryMethodSmooth:return Qo;case this.InterpolantFactoryMethodBezier:return hh}}getValueSize(){return this.values.length/this.times.length}shift(t){if(t!==0){let e=this.times;for(let n=0,s=e.length;n!==s;++n)e[n]+=t;jo(this.settings)&&(df(this.settings.inTangents,t),df(this.settings.outTangents,t))}return this}scale(t){if(t!==1){let e=this.times;for(let n=0,s=e.length;n!==s;++n)e[n]*=t;jo(this.settings)&&(ff(this.settings.inTangents,t),ff(this.settings.outTangents,t))}return this}trim(t,e){let n=this.times,s=n.length,r=0,o=s-1;for(;r!==s&&n[r]<t;)++r;for(;o!==-1&&n[o]>e;)--o;if(++o,r!==0||o!==s){r>=o&&(o=Math.max(o,1),r=o-1);let a=this.getValueSize();this.times=n.slice(r,o),this.values=this.values.slice(r*a,o*a)}return this}validate(){let t=!0,e=this.getValueSize();e-Math.floor(e)!==0&&(Lt("KeyframeTrack: Invalid value size in track.",this),t=!1);let n=this.times,s=this.values,r=n.length;r===0&&(Lt("KeyframeTrack: Track is empty.",this),t=!1);let o=null;for(let a=0;a!==r;a++){let l=n[a];if(typeof l=="number"&&isNaN(l)){Lt("KeyframeTrack: Time is not a valid number.",this,a,l),t=!1;break}if(o!==null&&o>l){Lt("KeyframeTrack: Out of order keys.",this,a,l,o),t=!1;break}o=l}if(s!==void 0&&C0(s))for(let a=0,l=s.length;a!==l;++a){let c=s[a];if(isNaN(c)){Lt("KeyframeTrack: Value is not a valid number.",this,a,c),t=!1;break}}return t}optimize(){let t=this.times.slice(),e=this.values.slice(),n=this.getValueSize(),s=this.getInterpolation()===Qo,r=t.length-1,o=1;for(let a=1;a<r;++a){let l=!1,c=t[a],h=t[a+1];if(c!==h&&(a!==1||c!==t[0]))if(s)l=!0;else{let d=a*n,u=d-n,f=d+n;for(let g=0;g!==n;++g){let x=e[d+g];if(x!==e[u+g]||x!==e[f+g]){l=!0;break}}}if(l){if(a!==o){t[o]=t[a];let d=a*n,u=o*n;for(let f=0;f!==n;++f)e[u+f]=e[d+f]}++o}}if(r>0){t[o]=t[r];for(let a=r*n,l=o*n,c=0;c!==n;++c)e[l+c]=e[a+c];++o}return o!==t.length?(this.times=t.slice(0,o),this.values=e.slice(0,o*n)):(this.times=t,this.values=e),this}clone(){let t=this.times.slice(),e=this.values.slice(),n=this.constructor,s=new n(this.name,t,e);return s.createInterpolant=this.createInterpolant,jo(this.settings)&&(s.settings={inTangents:this.settings.inTangents.slice(),outTangents:this.settings.outTangents.slice()}),s}};function df(i,t){for(let e=0,n=i.length;e!==n;e+=2)i[e]+=t}function ff(i,t){for(let e=0,n=i.length;e!==n;e+=2)i[e]*=t}gn.prototype.ValueTypeName="";gn.prototype.TimeBufferType=Float32Array;gn.prototype.ValueBufferType=Float32Array;gn.prototype.DefaultInterpolation=ca;var Ui=class extends gn{constructor(t,e,n){super(t,e,n)}};Ui.prototype.ValueTypeName="bool";Ui.prototype.ValueBufferType=Array;Ui.prototype.DefaultInterpolation=pr;Ui.prototype.InterpolantFactoryMethodLinear=void 0;Ui.prototype.InterpolantFactoryMethodSmooth=void 0;var Ea=class extends gn{constructor(t,e,n,s){super(t,e,n,s)}};Ea.prototype.ValueTypeName="color";var Aa=class extends gn{constructor(t,e,n,s){super(t,e,n,s)}};Aa.prototype.ValueTypeName="number";var Ta=class extends Ni{constructor(t,e,n,s){super(t,e,n,s)}interpolate_(t,e,n,s){let r=this.resultBuffer,o=this.sampleValues,a=this.valueSize,l=(n-e)/(s-e),c=t*a;for(let h=c+a;c!==h;c+=4)fn.slerpFlat(r,0,o,c-a,o,c,l);return r}},Dr=class extends gn{constructor(t,e,n,s){super(t,e,n,s)}InterpolantFactoryMethodLinear(t){return new Ta(this.times,this.values,this.getValueSize(),t)}};Dr.prototype.ValueTypeName="quaternion";Dr.prototype.InterpolantFactoryMethodSmooth=void 0;var Fi=class extends gn{constructor(t,e,n){super(t,e,n)}};Fi.prototype.ValueTypeName="string";Fi.prototype.ValueBufferType=Array;Fi.prototype.DefaultInterpolation=pr;Fi.prototype.InterpolantFactoryMethodLinear=void 0;Fi.prototype.InterpolantFactoryMethodSmooth=void 0;var Ca=class extends gn{constructor(t,e,n,s){super(t,e,n,s)}};Ca.prototype.ValueTypeName="vector";var Ra=class{constructor(t,e,n){let s=this,r=!1,o=0,a=0,l,c=[];this.onStart=void 0,this.onLoad=t,this.onProgress=e,this.onError=n,this._abortController=null,this.itemStart=function(h){a++,r===!1&&s.onStart!==void 0&&s.onStart(h,o,a),r=!0},this.itemEnd=function(h){o++,s.onProgress!==void 0&&s.onProgress(h,o,a),o===a&&(r=!1,s.onLoad!==void 0&&s.onLoad())},this.itemError=function(h){s.onError!==void 0&&s.onError(h)},this.resolveURL=function(h){return h=h.normalize("NFC"),l?l(h):h},this.setURLModifier=function(h){return l=h,this},this.addHandler=function(h,d){return c.push(h,d),this},this.removeHandler=function(h){let d=c.indexOf(h);return d!==-1&&c.splice(d,2),this},this.getHandler=function(h){for(let d=0,u=c.length;d<u;d+=2){let f=c[d],g=c[d+1];if(f.global&&(f.lastIndex=0),f.test(h))return g}return null},this.abort=function(){return this.abortController.abort(),this._abortController=null,this}}get abortController(){return this._abortController||(this._abortController=new AbortController),this._abortController}},ap=new Ra,Pa=class{constructor(t){this.manager=t!==void 0?t:ap,this.crossOrigin="anonymous",this.withCredentials=!1,this.path="",this.resourcePath="",this.requestHeader={},this.priority="auto",this.cache="default"}load(){}loadAsync(t,e){let n=this;return new Promise(function(s,r){n.load(t,s,e,r)})}parse(){}setCrossOrigin(t){return this.crossOrigin=t,this}setWithCredentials(t){return this.withCredentials=t,this}setPath(t){return this.path=t,this}setResourcePath(t){return this.resourcePath=t,this}setRequestHeader(t){return this.requestHeader=t,this}setPriority(t){return this.priority=t,this}setCache(t){return this.cache=t,this}abort(){return this}};Pa.DEFAULT_MATERIAL_NAME="__DEFAULT";var Zo=new P,Ko=new fn,Yn=new P,Nr=class extends an{constructor(){super(),this.isCamera=!0,this.type="Camera",this.matrixWorldInverse=new jt,this.projectionMatrix=new jt,this.projectionMatrixInverse=new jt,this.coordinateSystem=Tn,this._reversedDepth=!1}get reversedDepth(){return this._reversedDepth}copy(t,e){return super.copy(t,e),this.matrixWorldInverse.copy(t.matrixWorldInverse),this.projectionMatrix.copy(t.projectionMatrix),this.projectionMatrixInverse.copy(t.projectionMatrixInverse),this.coordinateSystem=t.coordinateSystem,this}getWorldDirection(t){return super.getWorldDirection(t).negate()}updateMatrixWorld(t){super.updateMatrixWorld(t),this.matrixWorld.decompose(Zo,Ko,Yn),Yn.x===1&&Yn.y===1&&Yn.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose(Zo,Ko,Yn.set(1,1,1)).invert()}updateWorldMatrix(t,e,n=!1){super.updateWorldMatrix(t,e,n),this.matrixWorld.decompose(Zo,Ko,Yn),Yn.x===1&&Yn.y===1&&Yn.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose(Zo,Ko,Yn.set(1,1,1)).invert()}clone(){return new this.constructor().copy(this)}},Ii=new P,pf=new Ct,mf=new Ct,tn=class extends Nr{constructor(t=50,e=1,n=.1,s=2e3){super(),this.isPerspectiveCamera=!0,this.type="PerspectiveCamera",this.fov=t,this.zoom=1,this.near=n,this.far=s,this.focus=10,this.aspect=e,this.view=null,this.filmGauge=35,this.filmOffset=0,this.updateProjectionMatrix()}copy(t,e){return super.copy(t,e),this.fov=t.fov,this.zoom=t.zoom,this.near=t.near,this.far=t.far,this.focus=t.focus,this.aspect=t.aspect,this.view=t.view===null?null:Object.assign({},t.view),this.filmGauge=t.filmGauge,this.filmOffset=t.filmOffset,this}setFocalLength(t){let e=.5*this.getFilmHeight()/t;this.fov=Ps*2*Math.atan(e),this.updateProjectionMatrix()}getFocalLength(){let t=Math.tan(dr*.5*this.fov);return .5*this.getFilmHeight()/t}getEffectiveFOV(){return Ps*2*Math.atan(Math.tan(dr*.5*this.fov)/this.zoom)}getFilmWidth(){return this.filmGauge*Math.min(this.aspect,1)}getFilmHeight(){return this.filmGauge/Math.max(this.aspect,1)}getViewBounds(t,e,n){Ii.set(-1,-1,.5).applyMatrix4(this.projectionMatrixInverse),e.set(Ii.x,Ii.y).multiplyScalar(-t/Ii.z),Ii.set(1,1,.5).applyMatrix4(this.projectionMatrixInverse),n.set(Ii.x,Ii.y).multiplyScalar(-t/Ii.z)}getViewSize(t,e){return this.getViewBounds(t,pf,mf),e.subVectors(mf,pf)}setViewOffset(t,e,n,s,r,o){this.aspect=t/e,this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=e,this.view.offsetX=n,this.view.offsetY=s,this.view.width=r,this.view.height=o,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=this.near,e=t*Math.tan(dr*.5*this.fov)/this.zoom,n=2*e,s=this.aspect*n,r=-.5*s,o=this.view;if(this.view!==null&&this.view.enabled){let l=o.fullWidth,c=o.fullHeight;r+=o.offsetX*s/l,e-=o.offsetY*n/c,s*=o.width/l,n*=o.height/c}let a=this.filmOffset;a!==0&&(r+=t*a/this.getFilmWidth()),this.projectionMatrix.makePerspective(r,r+s,e,e-n,t,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let e=super.toJSON(t);return e.object.fov=this.fov,e.object.zoom=this.zoom,e.object.near=this.near,e.object.far=this.far,e.object.focus=this.focus,e.object.aspect=this.aspect,this.view!==null&&(e.object.view=Object.assign({},this.view)),e.object.filmGauge=this.filmGauge,e.object.filmOffset=this.filmOffset,e}};var Bs=class extends Nr{constructor(t=-1,e=1,n=1,s=-1,r=.1,o=2e3){super(),this.isOrthographicCamera=!0,this.type="OrthographicCamera",this.zoom=1,this.view=null,this.left=t,this.right=e,this.top=n,this.bottom=s,this.near=r,this.far=o,this.updateProjectionMatrix()}copy(t,e){return super.copy(t,e),this.left=t.left,this.right=t.right,this.top=t.top,this.bottom=t.bottom,this.near=t.near,this.far=t.far,this.zoom=t.zoom,this.view=t.view===null?null:Object.assign({},t.view),this}setViewOffset(t,e,n,s,r,o){this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=e,this.view.offsetX=n,this.view.offsetY=s,this.view.width=r,this.view.height=o,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=(this.right-this.left)/(2*this.zoom),e=(this.top-this.bottom)/(2*this.zoom),n=(this.right+this.left)/2,s=(this.top+this.bottom)/2,r=n-t,o=n+t,a=s+e,l=s-e;if(this.view!==null&&this.view.enabled){let c=(this.right-this.left)/this.view.fullWidth/this.zoom,h=(this.top-this.bottom)/this.view.fullHeight/this.zoom;r+=c*this.view.offsetX,o=r+c*this.view.width,a-=h*this.view.offsetY,l=a-h*this.view.height}this.projectionMatrix.makeOrthographic(r,o,a,l,this.near,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let e=super.toJSON(t);return e.object.zoom=this.zoom,e.object.left=this.left,e.object.right=this.right,e.object.top=this.top,e.object.bottom=this.bottom,e.object.near=this.near,e.object.far=this.far,this.view!==null&&(e.object.view=Object.assign({},this.view)),e}};var Ur=class extends he{constructor(){super(),this.isInstancedBufferGeometry=!0,this.type="InstancedBufferGeometry",this.instanceCount=1/0}copy(t){return super.copy(t),this.instanceCount=t.instanceCount,this}toJSON(){let t=super.toJSON();return t.instanceCount=this.instanceCount,t.isInstancedBufferGeometry=!0,t}};var Ss=-90,Ms=1,ks=class extends an{constructor(t,e,n){super(),this.type="CubeCamera",this.renderTarget=n,this.coordinateSystem=null,this.activeMipmapLevel=0;let s=new tn(Ss,Ms,t,e);s.layers=this.layers,this.add(s);let r=new tn(Ss,Ms,t,e);r.layers=this.layers,this.add(r);let o=new tn(Ss,Ms,t,e);o.layers=this.layers,this.add(o);let a=new tn(Ss,Ms,t,e);a.layers=this.layers,this.add(a);let l=new tn(Ss,Ms,t,e);l.layers=this.layers,this.add(l);let c=new tn(Ss,Ms,t,e);c.layers=this.layers,this.add(c)}updateCoordinateSystem(){let t=this.coordinateSystem,e=this.children.concat(),[n,s,r,o,a,l]=e;for(let c of e)this.remove(c);if(t===Tn)n.up.set(0,1,0),n.lookAt(1,0,0),s.up.set(0,1,0),s.lookAt(-1,0,0),r.up.set(0,0,-1),r.lookAt(0,1,0),o.up.set(0,0,1),o.lookAt(0,-1,0),a.up.set(0,1,0),a.lookAt(0,0,1),l.up.set(0,1,0),l.lookAt(0,0,-1);else if(t===vr)n.up.set(0,-1,0),n.lookAt(-1,0,0),s.up.set(0,-1,0),s.lookAt(1,0,0),r.up.set(0,0,1),r.lookAt(0,1,0),o.up.set(0,0,-1),o.lookAt(0,-1,0),a.up.set(0,-1,0),a.lookAt(0,0,1),l.up.set(0,-1,0),l.lookAt(0,0,-1);else throw new Error("THREE.CubeCamera.updateCoordinateSystem(): Invalid coordinate system: "+t);for(let c of e)this.add(c),c.updateMatrixWorld()}update(t,e){this.parent===null&&this.updateMatrixWorld();let{renderTarget:n,activeMipmapLevel:s}=this;this.coordinateSystem!==t.coordinateSystem&&(this.coordinateSystem=t.coordinateSystem,this.updateCoordinateSystem());let[r,o,a,l,c,h]=this.children,d=t.getRenderTarget(),u=t.getActiveCubeFace(),f=t.getActiveMipmapLevel(),g=t.xr.enabled;t.xr.enabled=!1;let x=n.texture.mipmapsAutoUpdate;n.texture.mipmapsAutoUpdate=!1;let p=!1;t.isWebGLRenderer===!0?p=t.state.buffers.depth.getReversed():p=t.reversedDepthBuffer,t.setRenderTarget(n,0,s),p&&t.autoClear===!1&&t.clearDepth(),t.render(e,r),t.setRenderTarget(n,1,s),p&&t.autoClear===!1&&t.clearDepth(),t.render(e,o),t.setRenderTarget(n,2,s),p&&t.autoClear===!1&&t.clearDepth(),t.render(e,a),t.setRenderTarget(n,3,s),p&&t.autoClear===!1&&t.clearDepth(),t.render(e,l),t.setRenderTarget(n,4,s),p&&t.autoClear===!1&&t.clearDepth(),t.render(e,c),n.texture.mipmapsAutoUpdate=x,t.setRenderTarget(n,5,s),p&&t.autoClear===!1&&t.clearDepth(),t.render(e,h),t.setRenderTarget(d,u,f),t.xr.enabled=g,n.texture.needsPMREMUpdate=!0}},Ia=class extends tn{constructor(t=[]){super(),this.isArrayCamera=!0,this.isMultiViewCamera=!1,this.cameras=t,this.perCameraFrustumCulled=!1}};var iu="\\[\\]\\.:\\/",Dv=new RegExp("["+iu+"]","g"),su="[^"+iu+"]",Nv="[^"+iu.replace("\\.","")+"]",Uv=/((?:WC+[\/:])*)/.source.replace("WC",su),Fv=/(WCOD+)?/.source.replace("WCOD",Nv),Ov=/(?:\.(WC+)(?:\[(.+)\])?)?/.source.replace("WC",su),Bv=/\.(WC+)(?:\[(.+)\])?/.source.replace("WC",su),kv=new RegExp("^"+Uv+Fv+Ov+Bv+"$"),zv=["material","materials","bones","map"],xh=class{constructor(t,e,n){let s=n||ae.parseTrackName(e);this._targetGroup=t,this._bindings=t.subscribe_(e,s)}getValue(t,e){this.bind();let n=this._targetGroup.nCachedObjects_,s=this._bindings[n];s!==void 0&&s.getValue(t,e)}setValue(t,e){let n=this._bindings;for(let s=this._targetGroup.nCachedObjects_,r=n.length;s!==r;++s)n[s].setValue(t,e)}bind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,n=t.length;e!==n;++e)t[e].bind()}unbind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,n=t.length;e!==n;++e)t[e].unbind()}},ae=class i{constructor(t,e,n){this.path=e,this.parsedPath=n||i.parseTrackName(e),this.node=i.findNode(t,this.parsedPath.nodeName),this.rootNode=t,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}static create(t,e,n){return t&&t.isAnimationObjectGroup?new i.Composite(t,e,n):new i(t,e,n)}static sanitizeNodeName(t){return t.replace(/\s/g,"_").replace(Dv,"")}static parseTrackName(t){let e=kv.exec(t);if(e===null)throw new Error("THREE.PropertyBinding: Cannot parse trackName: "+t);let n={nodeName:e[2],objectName:e[3],objectIndex:e[4],propertyName:e[5],propertyIndex:e[6]},s=n.nodeName&&n.nodeName.lastIndexOf(".");if(s!==void 0&&s!==-1){let r=n.nodeName.substring(s+1);zv.indexOf(r)!==-1&&(n.nodeName=n.nodeName.substring(0,s),n.objectName=r)}if(n.propertyName===null||n.propertyName.length===0)throw new Error("THREE.PropertyBinding: can not parse propertyName from trackName: "+t);return n}static findNode(t,e){if(e===void 0||e===""||e==="."||e===-1||e===t.name||e===t.uuid)return t;if(t.skeleton){let n=t.skeleton.getBoneByName(e);if(n!==void 0)return n}if(t.children){let n=function(r){for(let o=0;o<r.length;o++){let a=r[o];if(a.name===e||a.uuid===e)return a;let l=n(a.children);if(l)return l}return null},s=n(t.children);if(s)return s}return null}_getValue_unavailable(){}_setValue_unavailable(){}_getValue_direct(t,e){t[e]=this.targetObject[this.propertyName]}_getValue_array(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)t[e++]=n[s]}_getValue_arrayElement(t,e){t[e]=this.resolvedProperty[this.propertyIndex]}_getValue_toArray(t,e){this.resolvedProperty.toArray(t,e)}_setValue_direct(t,e){this.targetObject[this.propertyName]=t[e]}_setValue_direct_setNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.needsUpdate=!0}_setValue_direct_setMatrixWorldNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_array(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)n[s]=t[e++]}_setValue_array_setNeedsUpdate(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)n[s]=t[e++];this.targetObject.needsUpdate=!0}_setValue_array_setMatrixWorldNeedsUpdate(t,e){let n=this.resolvedProperty;for(let s=0,r=n.length;s!==r;++s)n[s]=t[e++];this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_arrayElement(t,e){this.resolvedProperty[this.propertyIndex]=t[e]}_setValue_arrayElement_setNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.needsUpdate=!0}_setValue_arrayElement_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_fromArray(t,e){this.resolvedProperty.fromArray(t,e)}_setValue_fromArray_setNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.needsUpdate=!0}_setValue_fromArray_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.matrixWorldNeedsUpdate=!0}_getValue_unbound(t,e){this.bind(),this.getValue(t,e)}_setValue_unbound(t,e){this.bind(),this.setValue(t,e)}bind(){let t=this.node,e=this.parsedPath,n=e.objectName,s=e.propertyName,r=e.propertyIndex;if(t||(t=i.findNode(this.rootNode,e.nodeName),this.node=t),this.getValue=this._getValue_unavailable,this.setValue=this._setValue_unavailable,!t){Tt("PropertyBinding: No target node found for track: "+this.path+".");return}if(n){let c=e.objectIndex;switch(n){case"materials":if(!t.material){Lt("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.materials){Lt("PropertyBinding: Can not bind to material.materials as node.material does not have a materials array.",this);return}t=t.material.materials;break;case"bones":if(!t.skeleton){Lt("PropertyBinding: Can not bind to bones as node does not have a skeleton.",this);return}t=t.skeleton.bones;for(let h=0;h<t.length;h++)if(t[h].name===c){c=h;break}break;case"map":if("map"in t){t=t.map;break}if(!t.material){Lt("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.map){Lt("PropertyBinding: Can not bind to material.map as node.material does not have a map.",this);return}t=t.material.map;break;default:if(t[n]===void 0){Lt("PropertyBinding: Can not bind to objectName of node undefined.",this);return}t=t[n]}if(c!==void 0){if(t[c]===void 0){Lt("PropertyBinding: Trying to bind to objectIndex of objectName, but is undefined.",this,t);return}t=t[c]}}let o=t[s];if(o===void 0){let c=e.nodeName;Lt("PropertyBinding: Trying to update property for track: "+c+"."+s+" but it wasn't found.",t);return}let a=this.Versioning.None;this.targetObject=t,t.isMaterial===!0?a=this.Versioning.NeedsUpdate:t.isObject3D===!0&&(a=this.Versioning.MatrixWorldNeedsUpdate);let l=this.BindingType.Direct;if(r!==void 0){if(s==="morphTargetInfluences"){if(!t.geometry){Lt("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.",this);return}if(!t.geometry.morphAttributes){Lt("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.morphAttributes.",this);return}t.morphTargetDictionary[r]!==void 0&&(r=t.morphTargetDictionary[r])}l=this.BindingType.ArrayElement,this.resolvedProperty=o,this.propertyIndex=r}else o.fromArray!==void 0&&o.toArray!==void 0?(l=this.BindingType.HasFromToArray,this.resolvedProperty=o):Array.isArray(o)?(l=this.BindingType.EntireArray,this.resolvedProperty=o):this.propertyName=s;this.getValue=this.GetterByBindingType[l],this.setValue=this.SetterByBindingTypeAndVersioning[l][a]}unbind(){this.node=null,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}};ae.Composite=xh;ae.prototype.BindingType={Direct:0,EntireArray:1,ArrayElement:2,HasFromToArray:3};ae.prototype.Versioning={None:0,NeedsUpdate:1,MatrixWorldNeedsUpdate:2};ae.prototype.GetterByBindingType=[ae.prototype._getValue_direct,ae.prototype._getValue_array,ae.prototype._getValue_arrayElement,ae.prototype._getValue_toArray];ae.prototype.SetterByBindingTypeAndVersioning=[[ae.prototype._setValue_direct,ae.prototype._setValue_direct_setNeedsUpdate,ae.prototype._setValue_direct_setMatrixWorldNeedsUpdate],[ae.prototype._setValue_array,ae.prototype._setValue_array_setNeedsUpdate,ae.prototype._setValue_array_setMatrixWorldNeedsUpdate],[ae.prototype._setValue_arrayElement,ae.prototype._setValue_arrayElement_setNeedsUpdate,ae.prototype._setValue_arrayElement_setMatrixWorldNeedsUpdate],[ae.prototype._setValue_fromArray,ae.prototype._setValue_fromArray_setNeedsUpdate,ae.prototype._setValue_fromArray_setMatrixWorldNeedsUpdate]];var FE=new Float32Array(1);var Oi=class extends fa{constructor(t,e,n=1){super(t,e),this.isInstancedInterleavedBuffer=!0,this.meshPerAttribute=n}copy(t){return super.copy(t),this.meshPerAttribute=t.meshPerAttribute,this}clone(t){let e=super.clone(t);return e.meshPerAttribute=this.meshPerAttribute,e}toJSON(t){let e=super.toJSON(t);return e.isInstancedInterleavedBuffer=!0,e.meshPerAttribute=this.meshPerAttribute,e}};var gf=new jt,Fr=class{constructor(t,e,n=0,s=1/0){this.ray=new pi(t,e),this.near=n,this.far=s,this.camera=null,this.layers=new Ls,this.params={Mesh:{},Line:{threshold:1},LOD:{},Points:{threshold:1},Sprite:{}}}set(t,e){this.ray.set(t,e)}setFromCamera(t,e){e.isPerspectiveCamera?(this.ray.origin.setFromMatrixPosition(e.matrixWorld),this.ray.direction.set(t.x,t.y,.5).unproject(e).sub(this.ray.origin).normalize(),this.camera=e):e.isOrthographicCamera?(this.ray.origin.set(t.x,t.y,e.projectionMatrix.elements[14]).unproject(e),this.ray.direction.set(0,0,-1).transformDirection(e.matrixWorld),this.camera=e):Lt("Raycaster: Unsupported camera type: "+e.type)}setFromXRController(t){return gf.identity().extractRotation(t.matrixWorld),this.ray.origin.setFromMatrixPosition(t.matrixWorld),this.ray.direction.set(0,0,-1).applyMatrix4(gf),this}intersectObject(t,e=!0,n=[]){return _h(t,this,n,e),n.sort(vf),n}intersectObjects(t,e=!0,n=[]){for(let s=0,r=t.length;s<r;s++)_h(t[s],this,n,e);return n.sort(vf),n}};function vf(i,t){return i.distance-t.distance}function _h(i,t,e,n){let s=!0;if(i.layers.test(t.layers)&&i.raycast(t,e)===!1&&(s=!1),s===!0&&n===!0){let r=i.children;for(let o=0,a=r.length;o<a;o++)_h(r[o],t,e,!0)}}var kn=class{constructor(t=1,e=0,n=0){this.radius=t,this.phi=e,this.theta=n}set(t,e,n){return this.radius=t,this.phi=e,this.theta=n,this}copy(t){return this.radius=t.radius,this.phi=t.phi,this.theta=t.theta,this}makeSafe(){return this.phi=Ft(this.phi,1e-6,Math.PI-1e-6),this}setFromVector3(t){return this.setFromCartesianCoords(t.x,t.y,t.z)}setFromCartesianCoords(t,e,n){return this.radius=Math.sqrt(t*t+e*e+n*n),this.radius===0?(this.theta=0,this.phi=0):(this.theta=Math.atan2(t,n),this.phi=Math.acos(Ft(e/this.radius,-1,1))),this}clone(){return new this.constructor().copy(this)}};var yh=class{static{this.prototype.isMatrix2=!0}constructor(t,e,n,s){this.elements=[1,0,0,1],t!==void 0&&this.set(t,e,n,s)}identity(){return this.set(1,0,0,1),this}fromArray(t,e=0){for(let n=0;n<4;n++)this.elements[n]=t[n+e];return this}set(t,e,n,s){let r=this.elements;return r[0]=t,r[2]=e,r[1]=n,r[3]=s,this}};var xf=new P,Jo=new P,ws=new P,Es=new P,ch=new P,Hv=new P,Gv=new P,Or=class{constructor(t=new P,e=new P){this.start=t,this.end=e}set(t,e){return this.start.copy(t),this.end.copy(e),this}copy(t){return this.start.copy(t.start),this.end.copy(t.end),this}getCenter(t){return t.addVectors(this.start,this.end).multiplyScalar(.5)}delta(t){return t.subVectors(this.end,this.start)}distanceSq(){return this.start.distanceToSquared(this.end)}distance(){return this.start.distanceTo(this.end)}at(t,e){return this.delta(e).multiplyScalar(t).add(this.start)}closestPointToPointParameter(t,e){xf.subVectors(t,this.start),Jo.subVectors(this.end,this.start);let n=Jo.dot(Jo);if(n===0)return 0;let r=Jo.dot(xf)/n;return e&&(r=Ft(r,0,1)),r}closestPointToPoint(t,e,n){let s=this.closestPointToPointParameter(t,e);return this.delta(n).multiplyScalar(s).add(this.start)}distanceSqToLine3(t,e=Hv,n=Gv){let s=10000000000000001e-32,r,o,a=this.start,l=t.start,c=this.end,h=t.end;ws.subVectors(c,a),Es.subVectors(h,l),ch.subVectors(a,l);let d=ws.dot(ws),u=Es.dot(Es),f=Es.dot(ch);if(d<=s&&u<=s)return e.copy(a),n.copy(l),e.distanceToSquared(n);if(d<=s)r=0,o=f/u,o=Ft(o,0,1);else{let g=ws.dot(ch);if(u<=s)o=0,r=Ft(-g/d,0,1);else{let x=ws.dot(Es),p=d*u-x*x;p!==0?r=Ft((x*f-g*u)/p,0,1):r=0,o=(x*r+f)/u,o<0?(o=0,r=Ft(-g/d,0,1)):o>1&&(o=1,r=Ft((x-g)/d,0,1))}}return e.copy(a).addScaledVector(ws,r),n.copy(l).addScaledVector(Es,o),e.distanceToSquared(n)}applyMatrix4(t){return this.start.applyMatrix4(t),this.end.applyMatrix4(t),this}equals(t){return t.start.equals(this.start)&&t.end.equals(this.end)}clone(){return new this.constructor().copy(this)}};var Br=class extends On{constructor(t,e=null){super(),this.object=t,this.domElement=e,this.enabled=!0,this.state=-1,this.keys={},this.mouseButtons={LEFT:null,MIDDLE:null,RIGHT:null},this.touches={ONE:null,TWO:null}}connect(t){this.domElement!==null&&this.disconnect(),this.domElement=t}disconnect(){}dispose(){}update(){}};function ru(i,t,e,n){let s=Vv(n);switch(e){case zh:return i*t;case Gh:return i*t/s.components*s.byteLength;case Ba:return i*t/s.components*s.byteLength;case zi:return i*t*2/s.components*s.byteLength;case ka:return i*t*2/s.components*s.byteLength;case Hh:return i*t*3/s.components*s.byteLength;case _n:return i*t*4/s.components*s.byteLength;case za:return i*t*4/s.components*s.byteLength;case Hr:case Gr:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*8;case Vr:case Wr:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*16;case Ga:case Wa:return Math.max(i,16)*Math.max(t,8)/4;case Ha:case Va:return Math.max(i,8)*Math.max(t,8)/2;case $a:case Xa:case Ya:case ja:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*8;case qa:case $r:case Za:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*16;case Ka:return Math.floor((i+3)/4)*Math.floor((t+3)/4)*16;case Ja:return Math.floor((i+4)/5)*Math.floor((t+3)/4)*16;case Qa:return Math.floor((i+4)/5)*Math.floor((t+4)/5)*16;case tl:return Math.floor((i+5)/6)*Math.floor((t+4)/5)*16;case el:return Math.floor((i+5)/6)*Math.floor((t+5)/6)*16;case nl:return Math.floor((i+7)/8)*Math.floor((t+4)/5)*16;case il:return Math.floor((i+7)/8)*Math.floor((t+5)/6)*16;case sl:return Math.floor((i+7)/8)*Math.floor((t+7)/8)*16;case rl:return Math.floor((i+9)/10)*Math.floor((t+4)/5)*16;case ol:return Math.floor((i+9)/10)*Math.floor((t+5)/6)*16;case al:return Math.floor((i+9)/10)*Math.floor((t+7)/8)*16;case ll:return Math.floor((i+9)/10)*Math.floor((t+9)/10)*16;case cl:return Math.floor((i+11)/12)*Math.floor((t+9)/10)*16;case hl:return Math.floor((i+11)/12)*Math.floor((t+11)/12)*16;case ul:case dl:case fl:return Math.ceil(i/4)*Math.ceil(t/4)*16;case pl:case ml:return Math.ceil(i/4)*Math.ceil(t/4)*8;case Xr:case gl:return Math.ceil(i/4)*Math.ceil(t/4)*16}throw new Error(`Unable to determine texture byte length for ${e} format.`)}function Vv(i){switch(i){case vn:case Fh:return{byteLength:1,components:1};case Vs:case Oh:case xn:return{byteLength:2,components:1};case Fa:case Oa:return{byteLength:2,components:4};case Hn:case Ua:case Gn:return{byteLength:4,components:1};case Bh:case kh:return{byteLength:4,components:3}}throw new Error(`THREE.TextureUtils: Unknown texture type ${i}.`)}typeof window<"u"&&(window.__THREE__?Tt("WARNING: Multiple instances of Three.js being imported."):window.__THREE__="187");function Rp(){let i=null,t=!1,e=null,n=null;function s(r,o){n=i.requestAnimationFrame(s),e(r,o)}return{start:function(){t!==!0&&e!==null&&i!==null&&(n=i.requestAnimationFrame(s),t=!0)},stop:function(){i!==null&&i.cancelAnimationFrame(n),t=!1},setAnimationLoop:function(r){e=r},setContext:function(r){i=r}}}function $v(i){let t=new WeakMap;function e(a,l){let c=a.array,h=a.usage,d=c.byteLength,u=i.createBuffer();i.bindBuffer(l,u),i.bufferData(l,c,h),a.onUploadCallback();let f;if(c instanceof Float32Array)f=i.FLOAT;else if(typeof Float16Array<"u"&&c instanceof Float16Array)f=i.HALF_FLOAT;else if(c instanceof Uint16Array)a.isFloat16BufferAttribute?f=i.HALF_FLOAT:f=i.UNSIGNED_SHORT;else if(c instanceof Int16Array)f=i.SHORT;else if(c instanceof Uint32Array)f=i.UNSIGNED_INT;else if(c instanceof Int32Array)f=i.INT;else if(c instanceof Int8Array)f=i.BYTE;else if(c instanceof Uint8Array)f=i.UNSIGNED_BYTE;else if(c instanceof Uint8ClampedArray)f=i.UNSIGNED_BYTE;else throw new Error("THREE.WebGLAttributes: Unsupported buffer data format: "+c);return{buffer:u,type:f,bytesPerElement:c.BYTES_PER_ELEMENT,version:a.version,size:d}}function n(a,l,c){let h=l.array,d=l.updateRanges;if(i.bindBuffer(c,a),d.length===0)i.bufferSubData(c,0,h);else{d.sort((f,g)=>f.start-g.start);let u=0;for(let f=1;f<d.length;f++){let g=d[u],x=d[f];x.start<=g.start+g.count+1?g.count=Math.max(g.count,x.start+x.count-g.start):(++u,d[u]=x)}d.length=u+1;for(let f=0,g=d.length;f<g;f++){let x=d[f];i.bufferSubData(c,x.start*h.BYTES_PER_ELEMENT,h,x.start,x.count)}l.clearUpdateRanges()}l.onUploadCallback()}function s(a){return a.isInterleavedBufferAttribute&&(a=a.data),t.get(a)}function r(a){a.isInterleavedBufferAttribute&&(a=a.data);let l=t.get(a);l&&(i.deleteBuffer(l.buffer),t.delete(a))}function o(a,l){if(a.isInterleavedBufferAttribute&&(a=a.data),a.isGLBufferAttribute){let h=t.get(a);(!h||h.version<a.version)&&t.set(a,{buffer:a.buffer,type:a.type,bytesPerElement:a.elementSize,version:a.version});return}let c=t.get(a);if(c===void 0)t.set(a,e(a,l));else if(c.version<a.version){if(c.size!==a.array.byteLength)throw new Error("THREE.WebGLAttributes: The size of the buffer attribute's array buffer does not match the original size. Resizing buffer attributes is not supported.");n(c.buffer,a,l),c.version=a.version}}return{get:s,remove:r,update:o}}var Xv=`#ifdef USE_ALPHAHASH
	if ( diffuseColor.a < getAlphaHashThreshold( vPosition ) ) discard;
#endif`,qv=`#ifdef USE_ALPHAHASH
	const float ALPHA_HASH_SCALE = 0.05;
	float hash2D( vec2 value ) {
		return fract( 1.0e4 * sin( 17.0 * value.x + 0.1 * value.y ) * ( 0.1 + abs( sin( 13.0 * value.y + value.x ) ) ) );
	}
	float hash3D( vec3 value ) {
		return hash2D( vec2( hash2D( value.xy ), value.z ) );
	}
	float getAlphaHashThreshold( vec3 position ) {
		float maxDeriv = max(
			length( dFdx( position.xyz ) ),
			length( dFdy( position.xyz ) )
		);
		float pixScale = 1.0 / ( ALPHA_HASH_SCALE * maxDeriv );
		vec2 pixScales = vec2(
			exp2( floor( log2( pixScale ) ) ),
			exp2( ceil( log2( pixScale ) ) )
		);
		vec2 alpha = vec2(
			hash3D( floor( pixScales.x * position.xyz ) ),
			hash3D( floor( pixScales.y * position.xyz ) )
		);
		float lerpFactor = fract( log2( pixScale ) );
		float x = ( 1.0 - lerpFactor ) * alpha.x + lerpFactor * alpha.y;
		float a = min( lerpFactor, 1.0 - lerpFactor );
		vec3 cases = vec3(
			x * x / ( 2.0 * a * ( 1.0 - a ) ),
			( x - 0.5 * a ) / ( 1.0 - a ),
			1.0 - ( ( 1.0 - x ) * ( 1.0 - x ) / ( 2.0 * a * ( 1.0 - a ) ) )
		);
		float threshold = ( x < ( 1.0 - a ) )
			? ( ( x < a ) ? cases.x : cases.y )
			: cases.z;
		return clamp( threshold , 1.0e-6, 1.0 );
	}
#endif`,Yv=`#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, vAlphaMapUv ).g;
#endif`,jv=`#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,Zv=`#ifdef USE_ALPHATEST
	#ifdef ALPHA_TO_COVERAGE
	diffuseColor.a = smoothstep( alphaTest, alphaTest + fwidth( diffuseColor.a ), diffuseColor.a );
	if ( diffuseColor.a == 0.0 ) discard;
	#else
	if ( diffuseColor.a < alphaTest ) discard;
	#endif
#endif`,Kv=`#ifdef USE_ALPHATEST
	uniform float alphaTest;
#endif`,Jv=`#ifdef USE_AOMAP
	float ambientOcclusion = ( texture2D( aoMap, vAoMapUv ).r - 1.0 ) * aoMapIntensity + 1.0;
	reflectedLight.indirectDiffuse *= ambientOcclusion;
	#if defined( USE_CLEARCOAT ) 
		clearcoatSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_SHEEN ) 
		sheenSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_ENVMAP ) && defined( STANDARD )
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		reflectedLight.indirectSpecular *= computeSpecularOcclusion( dotNV, ambientOcclusion, material.roughness );
	#endif
#endif`,Qv=`#ifdef USE_AOMAP
	uniform sampler2D aoMap;
	uniform float aoMapIntensity;
#endif`,tx=`#ifdef USE_BATCHING
	#if ! defined( GL_ANGLE_multi_draw )
	#define gl_DrawID _gl_DrawID
	uniform int _gl_DrawID;
	#endif
	uniform highp sampler2D batchingTexture;
	uniform highp usampler2D batchingIdTexture;
	mat4 getBatchingMatrix( const in float i ) {
		int size = textureSize( batchingTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( batchingTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( batchingTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( batchingTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( batchingTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
	float getIndirectIndex( const in int i ) {
		int size = textureSize( batchingIdTexture, 0 ).x;
		int x = i % size;
		int y = i / size;
		return float( texelFetch( batchingIdTexture, ivec2( x, y ), 0 ).r );
	}
#endif
#ifdef USE_BATCHING_COLOR
	uniform sampler2D batchingColorTexture;
	vec4 getBatchingColor( const in float i ) {
		int size = textureSize( batchingColorTexture, 0 ).x;
		int j = int( i );
		int x = j % size;
		int y = j / size;
		return texelFetch( batchingColorTexture, ivec2( x, y ), 0 );
	}
#endif`,ex=`#ifdef USE_BATCHING
	mat4 batchingMatrix = getBatchingMatrix( getIndirectIndex( gl_DrawID ) );
#endif`,nx=`vec3 transformed = vec3( position );
#ifdef USE_ALPHAHASH
	vPosition = vec3( position );
#endif`,ix=`vec3 objectNormal = vec3( normal );
#ifdef USE_TANGENT
	vec3 objectTangent = vec3( tangent.xyz );
#endif`,sx=`float G_BlinnPhong_Implicit( ) {
	return 0.25;
}
float D_BlinnPhong( const in float shininess, const in float dotNH ) {
	return RECIPROCAL_PI * ( shininess * 0.5 + 1.0 ) * pow( dotNH, shininess );
}
vec3 BRDF_BlinnPhong( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 specularColor, const in float shininess ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( specularColor, 1.0, dotVH );
	float G = G_BlinnPhong_Implicit( );
	float D = D_BlinnPhong( shininess, dotNH );
	return F * ( G * D );
} // validated`,rx=`#ifdef USE_IRIDESCENCE
	const mat3 XYZ_TO_REC709 = mat3(
		 3.2404542, -0.9692660,  0.0556434,
		-1.5371385,  1.8760108, -0.2040259,
		-0.4985314,  0.0415560,  1.0572252
	);
	vec3 Fresnel0ToIor( vec3 fresnel0 ) {
		vec3 sqrtF0 = sqrt( fresnel0 );
		return ( vec3( 1.0 ) + sqrtF0 ) / ( vec3( 1.0 ) - sqrtF0 );
	}
	vec3 IorToFresnel0( vec3 transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - vec3( incidentIor ) ) / ( transmittedIor + vec3( incidentIor ) ) );
	}
	float IorToFresnel0( float transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - incidentIor ) / ( transmittedIor + incidentIor ));
	}
	vec3 evalSensitivity( float OPD, vec3 shift ) {
		float phase = 2.0 * PI * OPD * 1.0e-9;
		vec3 val = vec3( 5.4856e-13, 4.4201e-13, 5.2481e-13 );
		vec3 pos = vec3( 1.6810e+06, 1.7953e+06, 2.2084e+06 );
		vec3 var = vec3( 4.3278e+09, 9.3046e+09, 6.6121e+09 );
		vec3 xyz = val * sqrt( 2.0 * PI * var ) * cos( pos * phase + shift ) * exp( - pow2( phase ) * var );
		xyz.x += 9.7470e-14 * sqrt( 2.0 * PI * 4.5282e+09 ) * cos( 2.2399e+06 * phase + shift[ 0 ] ) * exp( - 4.5282e+09 * pow2( phase ) );
		xyz /= 1.0685e-7;
		vec3 rgb = XYZ_TO_REC709 * xyz;
		return rgb;
	}
	vec3 evalIridescence( float outsideIOR, float eta2, float cosTheta1, float thinFilmThickness, vec3 baseF0 ) {
		vec3 I;
		float iridescenceIOR = mix( outsideIOR, eta2, smoothstep( 0.0, 0.03, thinFilmThickness ) );
		float sinTheta2Sq = pow2( outsideIOR / iridescenceIOR ) * ( 1.0 - pow2( cosTheta1 ) );
		float cosTheta2Sq = 1.0 - sinTheta2Sq;
		if ( cosTheta2Sq < 0.0 ) {
			return vec3( 1.0 );
		}
		float cosTheta2 = sqrt( cosTheta2Sq );
		float R0 = IorToFresnel0( iridescenceIOR, outsideIOR );
		float R12 = F_Schlick( R0, 1.0, cosTheta1 );
		float T121 = 1.0 - R12;
		float phi12 = 0.0;
		if ( iridescenceIOR < outsideIOR ) phi12 = PI;
		float phi21 = PI - phi12;
		vec3 baseIOR = Fresnel0ToIor( clamp( baseF0, 0.0, 0.9999 ) );		vec3 R1 = IorToFresnel0( baseIOR, iridescenceIOR );
		vec3 R23 = F_Schlick( R1, 1.0, cosTheta2 );
		vec3 phi23 = vec3( 0.0 );
		if ( baseIOR[ 0 ] < iridescenceIOR ) phi23[ 0 ] = PI;
		if ( baseIOR[ 1 ] < iridescenceIOR ) phi23[ 1 ] = PI;
		if ( baseIOR[ 2 ] < iridescenceIOR ) phi23[ 2 ] = PI;
		float OPD = 2.0 * iridescenceIOR * thinFilmThickness * cosTheta2;
		vec3 phi = vec3( phi21 ) + phi23;
		vec3 R123 = clamp( R12 * R23, 1e-5, 0.9999 );
		vec3 r123 = sqrt( R123 );
		vec3 Rs = pow2( T121 ) * R23 / ( vec3( 1.0 ) - R123 );
		vec3 C0 = R12 + Rs;
		I = C0;
		vec3 Cm = Rs - T121;
		for ( int m = 1; m <= 2; ++ m ) {
			Cm *= r123;
			vec3 Sm = 2.0 * evalSensitivity( float( m ) * OPD, float( m ) * phi );
			I += Cm * Sm;
		}
		return max( I, vec3( 0.0 ) );
	}
#endif`,ox=`#ifdef USE_BUMPMAP
	uniform sampler2D bumpMap;
	uniform float bumpScale;
	vec2 dHdxy_fwd() {
		vec2 dSTdx = dFdx( vBumpMapUv );
		vec2 dSTdy = dFdy( vBumpMapUv );
		float Hll = bumpScale * texture2D( bumpMap, vBumpMapUv ).x;
		float dBx = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdx ).x - Hll;
		float dBy = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdy ).x - Hll;
		return vec2( dBx, dBy );
	}
	vec3 perturbNormalArb( vec3 surf_pos, vec3 surf_norm, vec2 dHdxy, float faceDirection ) {
		vec3 vSigmaX = normalize( dFdx( surf_pos.xyz ) );
		vec3 vSigmaY = normalize( dFdy( surf_pos.xyz ) );
		vec3 vN = surf_norm;
		vec3 R1 = cross( vSigmaY, vN );
		vec3 R2 = cross( vN, vSigmaX );
		float fDet = dot( vSigmaX, R1 ) * faceDirection;
		vec3 vGrad = sign( fDet ) * ( dHdxy.x * R1 + dHdxy.y * R2 );
		return normalize( abs( fDet ) * surf_norm - vGrad );
	}
#endif`,ax=`#if NUM_CLIPPING_PLANES > 0
	vec4 plane;
	#ifdef ALPHA_TO_COVERAGE
		float distanceToPlane, distanceGradient;
		float clipOpacity = 1.0;
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
			distanceGradient = fwidth( distanceToPlane ) / 2.0;
			clipOpacity *= smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			if ( clipOpacity == 0.0 ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			float unionClipOpacity = 1.0;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
				distanceGradient = fwidth( distanceToPlane ) / 2.0;
				unionClipOpacity *= 1.0 - smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			}
			#pragma unroll_loop_end
			clipOpacity *= 1.0 - unionClipOpacity;
		#endif
		diffuseColor.a *= clipOpacity;
		if ( diffuseColor.a == 0.0 ) discard;
	#else
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			if ( dot( vClipPosition, plane.xyz ) > plane.w ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			bool clipped = true;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				clipped = ( dot( vClipPosition, plane.xyz ) > plane.w ) && clipped;
			}
			#pragma unroll_loop_end
			if ( clipped ) discard;
		#endif
	#endif
#endif`,lx=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
	uniform vec4 clippingPlanes[ NUM_CLIPPING_PLANES ];
#endif`,cx=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
#endif`,hx=`#if NUM_CLIPPING_PLANES > 0
	vClipPosition = - mvPosition.xyz;
#endif`,ux=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	diffuseColor *= vColor;
#endif`,dx=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	varying vec4 vColor;
#endif`,fx=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	varying vec4 vColor;
#endif`,px=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	vColor = vec4( 1.0 );
#endif
#ifdef USE_COLOR_ALPHA
	vColor *= color;
#elif defined( USE_COLOR )
	vColor.rgb *= color;
#endif
#ifdef USE_INSTANCING_COLOR
	vColor.rgb *= instanceColor.rgb;
#endif
#ifdef USE_BATCHING_COLOR
	vColor *= getBatchingColor( getIndirectIndex( gl_DrawID ) );
#endif`,mx=`#define PI 3.141592653589793
#define PI2 6.283185307179586
#define PI_HALF 1.5707963267948966
#define RECIPROCAL_PI 0.3183098861837907
#define RECIPROCAL_PI2 0.15915494309189535
#define EPSILON 1e-6
#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
#define whiteComplement( a ) ( 1.0 - saturate( a ) )
float pow2( const in float x ) { return x*x; }
vec3 pow2( const in vec3 x ) { return x*x; }
float pow3( const in float x ) { return x*x*x; }
float pow4( const in float x ) { float x2 = x*x; return x2*x2; }
float max3( const in vec3 v ) { return max( max( v.x, v.y ), v.z ); }
float average( const in vec3 v ) { return dot( v, vec3( 0.3333333 ) ); }
highp float rand( const in vec2 uv ) {
	const highp float a = 12.9898, b = 78.233, c = 43758.5453;
	highp float dt = dot( uv.xy, vec2( a,b ) ), sn = mod( dt, PI );
	return fract( sin( sn ) * c );
}
#ifdef HIGH_PRECISION
	float precisionSafeLength( vec3 v ) { return length( v ); }
#else
	float precisionSafeLength( vec3 v ) {
		float maxComponent = max3( abs( v ) );
		return length( v / maxComponent ) * maxComponent;
	}
#endif
struct IncidentLight {
	vec3 color;
	vec3 direction;
	bool visible;
};
struct ReflectedLight {
	vec3 directDiffuse;
	vec3 directSpecular;
	vec3 indirectDiffuse;
	vec3 indirectSpecular;
};
#ifdef USE_ALPHAHASH
	varying vec3 vPosition;
#endif
vec3 transformDirection( in vec3 dir, in mat4 matrix ) {
	return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );
}
#define inverseTransformDirection transformDirectionByInverseViewMatrix
vec3 transformNormalByInverseViewMatrix( in vec3 normal, in mat4 viewMatrix ) {
	return normalize( ( vec4( normal, 0.0 ) * viewMatrix ).xyz );
}
vec3 transformDirectionByInverseViewMatrix( in vec3 dir, in mat4 viewMatrix ) {
	return normalize( ( vec4( dir, 0.0 ) * viewMatrix ).xyz );
}
bool isPerspectiveMatrix( mat4 m ) {
	return m[ 2 ][ 3 ] == - 1.0;
}
vec2 equirectUv( in vec3 dir ) {
	float u = atan( dir.z, dir.x ) * RECIPROCAL_PI2 + 0.5;
	float v = asin( clamp( dir.y, - 1.0, 1.0 ) ) * RECIPROCAL_PI + 0.5;
	return vec2( u, v );
}
vec3 BRDF_Lambert( const in vec3 diffuseColor ) {
	return RECIPROCAL_PI * diffuseColor;
}
vec3 F_Schlick( const in vec3 f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
}
float F_Schlick( const in float f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
} // validated`,gx=`vec3 transformedNormal = objectNormal;
#ifdef USE_TANGENT
	vec3 transformedTangent = objectTangent;
#endif
#ifdef USE_BATCHING
	mat3 bm = mat3( batchingMatrix );
	transformedNormal /= vec3( dot( bm[ 0 ], bm[ 0 ] ), dot( bm[ 1 ], bm[ 1 ] ), dot( bm[ 2 ], bm[ 2 ] ) );
	transformedNormal = bm * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = bm * transformedTangent;
	#endif
#endif
#ifdef USE_INSTANCING
	mat3 im = mat3( instanceMatrix );
	transformedNormal /= vec3( dot( im[ 0 ], im[ 0 ] ), dot( im[ 1 ], im[ 1 ] ), dot( im[ 2 ], im[ 2 ] ) );
	transformedNormal = im * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = im * transformedTangent;
	#endif
#endif
transformedNormal = normalMatrix * transformedNormal;
#ifdef FLIP_SIDED
	transformedNormal = - transformedNormal;
#endif
#ifdef USE_TANGENT
	transformedTangent = ( modelViewMatrix * vec4( transformedTangent, 0.0 ) ).xyz;
#endif`,vx=`#ifdef USE_DISPLACEMENTMAP
	uniform sampler2D displacementMap;
	uniform float displacementScale;
	uniform float displacementBias;
#endif`,xx=`#ifdef USE_DISPLACEMENTMAP
	transformed += normalize( objectNormal ) * ( texture2D( displacementMap, vDisplacementMapUv ).x * displacementScale + displacementBias );
#endif`,_x=`#ifdef USE_EMISSIVEMAP
	vec4 emissiveColor = texture2D( emissiveMap, vEmissiveMapUv );
	#ifdef DECODE_VIDEO_TEXTURE_EMISSIVE
		emissiveColor = sRGBTransferEOTF( emissiveColor );
	#endif
	totalEmissiveRadiance *= emissiveColor.rgb;
#endif`,yx=`#ifdef USE_EMISSIVEMAP
	uniform sampler2D emissiveMap;
#endif`,bx="gl_FragColor = linearToOutputTexel( gl_FragColor );",Sx=`vec4 LinearTransferOETF( in vec4 value ) {
	return value;
}
vec4 sRGBTransferEOTF( in vec4 value ) {
	return vec4( mix( pow( value.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), value.rgb * 0.0773993808, vec3( lessThanEqual( value.rgb, vec3( 0.04045 ) ) ) ), value.a );
}
vec4 sRGBTransferOETF( in vec4 value ) {
	return vec4( mix( pow( value.rgb, vec3( 0.41666 ) ) * 1.055 - vec3( 0.055 ), value.rgb * 12.92, vec3( lessThanEqual( value.rgb, vec3( 0.0031308 ) ) ) ), value.a );
}`,Mx=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vec3 cameraToFrag;
		if ( isOrthographic ) {
			cameraToFrag = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToFrag = normalize( vWorldPosition - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vec3 reflectVec = reflect( cameraToFrag, worldNormal );
		#else
			vec3 reflectVec = refract( cameraToFrag, worldNormal, refractionRatio );
		#endif
	#else
		vec3 reflectVec = vReflect;
	#endif
	#ifdef ENVMAP_TYPE_CUBE
		vec4 envColor = textureCube( envMap, envMapRotation * reflectVec );
		#ifdef ENVMAP_BLENDING_MULTIPLY
			outgoingLight = mix( outgoingLight, outgoingLight * envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_MIX )
			outgoingLight = mix( outgoingLight, envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_ADD )
			outgoingLight += envColor.xyz * specularStrength * reflectivity;
		#endif
	#endif
#endif`,wx=`#ifdef USE_ENVMAP
	uniform float envMapIntensity;
	uniform mat3 envMapRotation;
	uniform samplerCube envMap;
	#ifdef ENVMAP_TYPE_PMREM
		float roughnessToMip( const in float roughness ) {
			float r = clamp( roughness, 0.0, 1.0 );
			return ENVMAP_MAX_LOD * r * ( 2.0 - r );
		}
	#endif
#endif`,Ex=`#ifdef USE_ENVMAP
	uniform float reflectivity;
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		varying vec3 vWorldPosition;
		uniform float refractionRatio;
	#else
		varying vec3 vReflect;
	#endif
#endif`,Ax=`#ifdef USE_ENVMAP
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		
		varying vec3 vWorldPosition;
	#else
		varying vec3 vReflect;
		uniform float refractionRatio;
	#endif
#endif`,Tx=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vWorldPosition = worldPosition.xyz;
	#else
		vec3 cameraToVertex;
		if ( isOrthographic ) {
			cameraToVertex = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToVertex = normalize( worldPosition.xyz - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vReflect = reflect( cameraToVertex, worldNormal );
		#else
			vReflect = refract( cameraToVertex, worldNormal, refractionRatio );
		#endif
	#endif
#endif`,Cx=`#ifdef USE_FOG
	vFogDepth = - mvPosition.z;
#endif`,Rx=`#ifdef USE_FOG
	varying float vFogDepth;
#endif`,Px=`#ifdef USE_FOG
	#ifdef FOG_EXP2
		float fogFactor = 1.0 - exp( - fogDensity * fogDensity * vFogDepth * vFogDepth );
	#else
		float fogFactor = smoothstep( fogNear, fogFar, vFogDepth );
	#endif
	gl_FragColor.rgb = mix( gl_FragColor.rgb, fogColor, fogFactor );
#endif`,Ix=`#ifdef USE_FOG
	uniform vec3 fogColor;
	varying float vFogDepth;
	#ifdef FOG_EXP2
		uniform float fogDensity;
	#else
		uniform float fogNear;
		uniform float fogFar;
	#endif
#endif`,Lx=`#ifdef USE_GRADIENTMAP
	uniform sampler2D gradientMap;
#endif
vec3 getGradientIrradiance( vec3 normal, vec3 lightDirection ) {
	float dotNL = dot( normal, lightDirection );
	vec2 coord = vec2( dotNL * 0.5 + 0.5, 0.0 );
	#ifdef USE_GRADIENTMAP
		return vec3( texture2D( gradientMap, coord ).r );
	#else
		vec2 fw = fwidth( coord ) * 0.5;
		return mix( vec3( 0.7 ), vec3( 1.0 ), smoothstep( 0.7 - fw.x, 0.7 + fw.x, coord.x ) );
	#endif
}`,Dx=`#ifdef USE_LIGHTMAP
	uniform sampler2D lightMap;
	uniform float lightMapIntensity;
#endif`,Nx=`LambertMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularStrength = specularStrength;`,Ux=`varying vec3 vViewPosition;
struct LambertMaterial {
	vec3 diffuseColor;
	float specularStrength;
};
void RE_Direct_Lambert( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Lambert( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Lambert
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Lambert`,Fx=`uniform bool receiveShadow;
uniform vec3 ambientLightColor;
#if defined( USE_LIGHT_PROBES )
	uniform vec3 lightProbe[ 9 ];
#endif
vec3 shGetIrradianceAt( in vec3 normal, in vec3 shCoefficients[ 9 ] ) {
	float x = normal.x, y = normal.y, z = normal.z;
	vec3 result = shCoefficients[ 0 ] * 0.886227;
	result += shCoefficients[ 1 ] * 2.0 * 0.511664 * y;
	result += shCoefficients[ 2 ] * 2.0 * 0.511664 * z;
	result += shCoefficients[ 3 ] * 2.0 * 0.511664 * x;
	result += shCoefficients[ 4 ] * 2.0 * 0.429043 * x * y;
	result += shCoefficients[ 5 ] * 2.0 * 0.429043 * y * z;
	result += shCoefficients[ 6 ] * ( 0.743125 * z * z - 0.247708 );
	result += shCoefficients[ 7 ] * 2.0 * 0.429043 * x * z;
	result += shCoefficients[ 8 ] * 0.429043 * ( x * x - y * y );
	return result;
}
vec3 getLightProbeIrradiance( const in vec3 lightProbe[ 9 ], const in vec3 normal ) {
	vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec3 irradiance = shGetIrradianceAt( worldNormal, lightProbe );
	return irradiance;
}
vec3 getAmbientLightIrradiance( const in vec3 ambientLightColor ) {
	vec3 irradiance = ambientLightColor;
	return irradiance;
}
float getDistanceAttenuation( const in float lightDistance, const in float cutoffDistance, const in float decayExponent ) {
	float distanceFalloff = 1.0 / max( pow( lightDistance, decayExponent ), 0.01 );
	if ( cutoffDistance > 0.0 ) {
		distanceFalloff *= pow2( saturate( 1.0 - pow4( lightDistance / cutoffDistance ) ) );
	}
	return distanceFalloff;
}
float getSpotAttenuation( const in float coneCosine, const in float penumbraCosine, const in float angleCosine ) {
	return smoothstep( coneCosine, penumbraCosine, angleCosine );
}
#if NUM_SUN_LIGHTS > 0
	struct SunLight {
		vec3 direction;
		vec3 color;
	};
	uniform SunLight sunLights[ NUM_SUN_LIGHTS ];
	void getSunLightInfo( const in SunLight sunLight, out IncidentLight light ) {
		light.color = sunLight.color;
		light.direction = sunLight.direction;
		light.visible = true;
	}
#endif
#if NUM_DIR_LIGHTS > 0
	struct DirectionalLight {
		vec3 direction;
		vec3 color;
	};
	uniform DirectionalLight directionalLights[ NUM_DIR_LIGHTS ];
	void getDirectionalLightInfo( const in DirectionalLight directionalLight, out IncidentLight light ) {
		light.color = directionalLight.color;
		light.direction = directionalLight.direction;
		light.visible = true;
	}
#endif
#if NUM_POINT_LIGHTS > 0
	struct PointLight {
		vec3 position;
		vec3 color;
		float distance;
		float decay;
	};
	uniform PointLight pointLights[ NUM_POINT_LIGHTS ];
	void getPointLightInfo( const in PointLight pointLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = pointLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float lightDistance = length( lVector );
		light.color = pointLight.color;
		light.color *= getDistanceAttenuation( lightDistance, pointLight.distance, pointLight.decay );
		light.visible = ( light.color != vec3( 0.0 ) );
	}
#endif
#if NUM_SPOT_LIGHTS > 0
	struct SpotLight {
		vec3 position;
		vec3 direction;
		vec3 color;
		float distance;
		float decay;
		float coneCos;
		float penumbraCos;
	};
	uniform SpotLight spotLights[ NUM_SPOT_LIGHTS ];
	void getSpotLightInfo( const in SpotLight spotLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = spotLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float angleCos = dot( light.direction, spotLight.direction );
		float spotAttenuation = getSpotAttenuation( spotLight.coneCos, spotLight.penumbraCos, angleCos );
		if ( spotAttenuation > 0.0 ) {
			float lightDistance = length( lVector );
			light.color = spotLight.color * spotAttenuation;
			light.color *= getDistanceAttenuation( lightDistance, spotLight.distance, spotLight.decay );
			light.visible = ( light.color != vec3( 0.0 ) );
		} else {
			light.color = vec3( 0.0 );
			light.visible = false;
		}
	}
#endif
#if NUM_RECT_AREA_LIGHTS > 0
	struct RectAreaLight {
		vec3 color;
		vec3 position;
		vec3 halfWidth;
		vec3 halfHeight;
	};
	uniform sampler2D ltc_1;	uniform sampler2D ltc_2;
	uniform RectAreaLight rectAreaLights[ NUM_RECT_AREA_LIGHTS ];
#endif
#if NUM_HEMI_LIGHTS > 0
	struct HemisphereLight {
		vec3 direction;
		vec3 skyColor;
		vec3 groundColor;
	};
	uniform HemisphereLight hemisphereLights[ NUM_HEMI_LIGHTS ];
	vec3 getHemisphereLightIrradiance( const in HemisphereLight hemiLight, const in vec3 normal ) {
		float dotNL = dot( normal, hemiLight.direction );
		float hemiDiffuseWeight = 0.5 * dotNL + 0.5;
		vec3 irradiance = mix( hemiLight.groundColor, hemiLight.skyColor, hemiDiffuseWeight );
		return irradiance;
	}
#endif
#include <lightprobes_pars_fragment>`,Ox=`#ifdef USE_ENVMAP
	vec3 getIBLIrradiance( const in vec3 normal ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * worldNormal, ENVMAP_MAX_LOD );
			return PI * envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	vec3 getIBLRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 reflectVec = reflect( - viewDir, normal );
			reflectVec = normalize( mix( reflectVec, normal, pow4( roughness ) ) );
			reflectVec = transformDirectionByInverseViewMatrix( reflectVec, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * reflectVec, roughnessToMip( roughness ) );
			return envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	#ifdef USE_RETROREFLECTION
		vec3 getIBLRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 retroVec = normalize( mix( viewDir, normal, pow4( roughness ) ) );
				retroVec = transformDirectionByInverseViewMatrix( retroVec, viewMatrix );
				vec4 envMapColor = textureLod( envMap, envMapRotation * retroVec, roughnessToMip( roughness ) );
				return envMapColor.rgb * envMapIntensity;
			#else
				return vec3( 0.0 );
			#endif
		}
	#endif
	#ifdef USE_ANISOTROPY
		vec3 getIBLAnisotropyRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 bentNormal = cross( bitangent, viewDir );
				bentNormal = normalize( cross( bentNormal, bitangent ) );
				bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
				return getIBLRadiance( viewDir, bentNormal, roughness );
			#else
				return vec3( 0.0 );
			#endif
		}
		#ifdef USE_RETROREFLECTION
			vec3 getIBLAnisotropyRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
				#ifdef ENVMAP_TYPE_PMREM
					vec3 bentNormal = cross( bitangent, viewDir );
					bentNormal = normalize( cross( bentNormal, bitangent ) );
					bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
					return getIBLRetroRadiance( viewDir, bentNormal, roughness );
				#else
					return vec3( 0.0 );
				#endif
			}
		#endif
	#endif
#endif`,Bx=`ToonMaterial material;
material.diffuseColor = diffuseColor.rgb;`,kx=`varying vec3 vViewPosition;
struct ToonMaterial {
	vec3 diffuseColor;
};
void RE_Direct_Toon( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 irradiance = getGradientIrradiance( geometryNormal, directLight.direction ) * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Toon( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Toon
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Toon`,zx=`BlinnPhongMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularColor = specular;
material.specularShininess = shininess;
material.specularStrength = specularStrength;`,Hx=`varying vec3 vViewPosition;
struct BlinnPhongMaterial {
	vec3 diffuseColor;
	vec3 specularColor;
	float specularShininess;
	float specularStrength;
};
void RE_Direct_BlinnPhong( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
	reflectedLight.directSpecular += irradiance * BRDF_BlinnPhong( directLight.direction, geometryViewDir, geometryNormal, material.specularColor, material.specularShininess ) * material.specularStrength;
}
void RE_IndirectDiffuse_BlinnPhong( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_BlinnPhong
#define RE_IndirectDiffuse		RE_IndirectDiffuse_BlinnPhong`,Gx=`PhysicalMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.diffuseContribution = diffuseColor.rgb * ( 1.0 - metalnessFactor );
material.metalness = metalnessFactor;
vec3 dxy = max( abs( dFdx( nonPerturbedNormal ) ), abs( dFdy( nonPerturbedNormal ) ) );
float geometryRoughness = max( max( dxy.x, dxy.y ), dxy.z );
material.roughness = max( roughnessFactor, 0.045 );
material.roughness += geometryRoughness;
material.roughness = min( material.roughness, 1.0 );
#ifdef USE_DIFFUSE_ROUGHNESS
	float diffuseRoughnessFactor = diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		diffuseRoughnessFactor *= texture2D( diffuseRoughnessMap, vDiffuseRoughnessMapUv ).r;
	#endif
	material.diffuseRoughness = saturate( diffuseRoughnessFactor );
#endif
#ifdef IOR
	material.ior = ior;
	#ifdef USE_SPECULAR
		float specularIntensityFactor = specularIntensity;
		vec3 specularColorFactor = specularColor;
		#ifdef USE_SPECULAR_COLORMAP
			specularColorFactor *= texture2D( specularColorMap, vSpecularColorMapUv ).rgb;
		#endif
		#ifdef USE_SPECULAR_INTENSITYMAP
			specularIntensityFactor *= texture2D( specularIntensityMap, vSpecularIntensityMapUv ).a;
		#endif
		material.specularF90 = mix( specularIntensityFactor, 1.0, metalnessFactor );
	#else
		float specularIntensityFactor = 1.0;
		vec3 specularColorFactor = vec3( 1.0 );
		material.specularF90 = 1.0;
	#endif
	material.specularColor = min( pow2( ( material.ior - 1.0 ) / ( material.ior + 1.0 ) ) * specularColorFactor, vec3( 1.0 ) ) * specularIntensityFactor;
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
#else
	material.specularColor = vec3( 0.04 );
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
	material.specularF90 = 1.0;
#endif
#ifdef USE_CLEARCOAT
	material.clearcoat = clearcoat;
	material.clearcoatRoughness = clearcoatRoughness;
	material.clearcoatF0 = vec3( 0.04 );
	material.clearcoatF90 = 1.0;
	#ifdef USE_CLEARCOATMAP
		material.clearcoat *= texture2D( clearcoatMap, vClearcoatMapUv ).x;
	#endif
	#ifdef USE_CLEARCOAT_ROUGHNESSMAP
		material.clearcoatRoughness *= texture2D( clearcoatRoughnessMap, vClearcoatRoughnessMapUv ).y;
	#endif
	material.clearcoat = saturate( material.clearcoat );	material.clearcoatRoughness = max( material.clearcoatRoughness, 0.045 );
	material.clearcoatRoughness += geometryRoughness;
	material.clearcoatRoughness = min( material.clearcoatRoughness, 1.0 );
#endif
#ifdef USE_DISPERSION
	material.dispersion = dispersion;
#endif
#ifdef USE_RETROREFLECTION
	material.retroreflectivity = retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	material.iridescence = iridescence;
	material.iridescenceIOR = iridescenceIOR;
	#ifdef USE_IRIDESCENCEMAP
		material.iridescence *= texture2D( iridescenceMap, vIridescenceMapUv ).r;
	#endif
	#ifdef USE_IRIDESCENCE_THICKNESSMAP
		material.iridescenceThickness = (iridescenceThicknessMaximum - iridescenceThicknessMinimum) * texture2D( iridescenceThicknessMap, vIridescenceThicknessMapUv ).g + iridescenceThicknessMinimum;
	#else
		material.iridescenceThickness = iridescenceThicknessMaximum;
	#endif
#endif
#ifdef USE_SHEEN
	material.sheenColor = sheenColor;
	#ifdef USE_SHEEN_COLORMAP
		material.sheenColor *= texture2D( sheenColorMap, vSheenColorMapUv ).rgb;
	#endif
	material.sheenRoughness = clamp( sheenRoughness, 0.0001, 1.0 );
	#ifdef USE_SHEEN_ROUGHNESSMAP
		material.sheenRoughness *= texture2D( sheenRoughnessMap, vSheenRoughnessMapUv ).a;
	#endif
#endif
#ifdef USE_ANISOTROPY
	#ifdef USE_ANISOTROPYMAP
		mat2 anisotropyMat = mat2( anisotropyVector.x, anisotropyVector.y, - anisotropyVector.y, anisotropyVector.x );
		vec3 anisotropyPolar = texture2D( anisotropyMap, vAnisotropyMapUv ).rgb;
		vec2 anisotropyV = anisotropyMat * normalize( 2.0 * anisotropyPolar.rg - vec2( 1.0 ) ) * anisotropyPolar.b;
	#else
		vec2 anisotropyV = anisotropyVector;
	#endif
	material.anisotropy = length( anisotropyV );
	if( material.anisotropy == 0.0 ) {
		anisotropyV = vec2( 1.0, 0.0 );
	} else {
		anisotropyV /= material.anisotropy;
		material.anisotropy = saturate( material.anisotropy );
	}
	material.alphaT = mix( pow2( material.roughness ), 1.0, pow2( material.anisotropy ) );
	material.anisotropyT = tbn[ 0 ] * anisotropyV.x + tbn[ 1 ] * anisotropyV.y;
	material.anisotropyB = tbn[ 1 ] * anisotropyV.x - tbn[ 0 ] * anisotropyV.y;
#endif`,Vx=`uniform sampler2D dfgLUT;
struct PhysicalMaterial {
	vec3 diffuseColor;
	vec3 diffuseContribution;
	vec3 specularColor;
	vec3 specularColorBlended;
	float roughness;
	float metalness;
	float specularF90;
	float dispersion;
	vec2 dfg;
	vec3 multiScatteringCompensation;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float diffuseRoughness;
	#endif
	#ifdef USE_RETROREFLECTION
		float retroreflectivity;
	#endif
	#ifdef USE_CLEARCOAT
		float clearcoat;
		float clearcoatRoughness;
		vec3 clearcoatF0;
		float clearcoatF90;
	#endif
	#ifdef USE_IRIDESCENCE
		float iridescence;
		float iridescenceIOR;
		float iridescenceThickness;
		vec3 iridescenceFresnel;
		vec3 iridescenceF0Dielectric;
		vec3 iridescenceF0Metallic;
	#endif
	#ifdef USE_SHEEN
		vec3 sheenColor;
		float sheenRoughness;
	#endif
	#ifdef IOR
		float ior;
	#endif
	#ifdef USE_TRANSMISSION
		float transmission;
		float transmissionAlpha;
		float thickness;
		float attenuationDistance;
		vec3 attenuationColor;
	#endif
	#ifdef USE_ANISOTROPY
		float anisotropy;
		float alphaT;
		vec3 anisotropyT;
		vec3 anisotropyB;
	#endif
};
vec3 clearcoatSpecularDirect = vec3( 0.0 );
vec3 clearcoatSpecularIndirect = vec3( 0.0 );
vec3 sheenSpecularDirect = vec3( 0.0 );
vec3 sheenSpecularIndirect = vec3(0.0 );
vec3 Schlick_to_F0( const in vec3 f, const in float f90, const in float dotVH ) {
    float x = clamp( 1.0 - dotVH, 0.0, 1.0 );
    float x2 = x * x;
    float x5 = clamp( x * x2 * x2, 0.0, 0.9999 );
    return ( f - vec3( f90 ) * x5 ) / ( 1.0 - x5 );
}
#ifdef USE_DIFFUSE_ROUGHNESS
	const float EON_EPSILON = 1e-7;
	float FON_DirectionalAlbedo( const in float mu, const in float roughness, const in float A ) {
		float muComp = 1.0 - mu;
		float gOverPi = muComp * ( 0.0571085289 + muComp * ( 0.491881867 + muComp * ( - 0.332181442 + muComp * 0.0714429953 ) ) );
		return A * ( 1.0 + roughness * gOverPi );
	}
	vec3 BRDF_EON( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 diffuseColor, const in float roughness ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return BRDF_Lambert( rho );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float s = dot( lightDir, viewDir ) - dotNL * dotNV;
		float sOverT = ( s > 0.0 ) ? s / max( max( dotNL, dotNV ), EON_EPSILON ) : s;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		vec3 singleScatter = rho * RECIPROCAL_PI * A * ( 1.0 + roughness * sOverT );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		float albedoV = FON_DirectionalAlbedo( dotNV, roughness, A );
		float albedoL = FON_DirectionalAlbedo( dotNL, roughness, A );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		vec3 multiScatter = rhoMultiScatter * RECIPROCAL_PI
			* max( EON_EPSILON, 1.0 - albedoV )
			* max( EON_EPSILON, 1.0 - albedoL )
			/ max( EON_EPSILON, 1.0 - averageAlbedo );
		return singleScatter + multiScatter;
	}
	vec3 EON_DirectionalAlbedo( const in vec3 diffuseColor, const in float roughness, const in float dotNV ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return rho;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		float directionalAlbedo = FON_DirectionalAlbedo( dotNV, roughness, A );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		return rho * directionalAlbedo + rhoMultiScatter * ( 1.0 - directionalAlbedo );
	}
#endif
float V_GGX_SmithCorrelated( const in float alpha, const in float dotNL, const in float dotNV ) {
	float a2 = pow2( alpha );
	float gv = dotNL * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNV ) );
	float gl = dotNV * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNL ) );
	return 0.5 / max( gv + gl, EPSILON );
}
float D_GGX( const in float alpha, const in float dotNH ) {
	float a2 = pow2( alpha );
	float denom = pow2( dotNH ) * ( a2 - 1.0 ) + 1.0;
	return RECIPROCAL_PI * a2 / pow2( denom );
}
#ifdef USE_ANISOTROPY
	float V_GGX_SmithCorrelated_Anisotropic( const in float alphaT, const in float alphaB, const in float dotTV, const in float dotBV, const in float dotTL, const in float dotBL, const in float dotNV, const in float dotNL ) {
		float gv = dotNL * length( vec3( alphaT * dotTV, alphaB * dotBV, dotNV ) );
		float gl = dotNV * length( vec3( alphaT * dotTL, alphaB * dotBL, dotNL ) );
		return 0.5 / max( gv + gl, EPSILON );
	}
	float D_GGX_Anisotropic( const in float alphaT, const in float alphaB, const in float dotNH, const in float dotTH, const in float dotBH ) {
		float a2 = alphaT * alphaB;
		highp vec3 v = vec3( alphaB * dotTH, alphaT * dotBH, a2 * dotNH );
		highp float v2 = dot( v, v );
		float w2 = a2 / v2;
		return RECIPROCAL_PI * a2 * pow2 ( w2 );
	}
#endif
#ifdef USE_CLEARCOAT
	vec3 BRDF_GGX_Clearcoat( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material) {
		vec3 f0 = material.clearcoatF0;
		float f90 = material.clearcoatF90;
		float roughness = max( material.clearcoatRoughness, 0.045 );
		float alpha = pow2( roughness );
		vec3 halfDir = normalize( lightDir + viewDir );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float dotNH = saturate( dot( normal, halfDir ) );
		float dotVH = saturate( dot( viewDir, halfDir ) );
		vec3 F = F_Schlick( f0, f90, dotVH );
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
		return F * ( V * D );
	}
#endif
vec3 BRDF_GGX( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material ) {
	vec3 f0 = material.specularColorBlended;
	float f90 = material.specularF90;
	float roughness = max( material.roughness, 0.045 );
	float alpha = pow2( roughness );
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( f0, f90, dotVH );
	#ifdef USE_IRIDESCENCE
		F = mix( F, material.iridescenceFresnel, material.iridescence );
	#endif
	#ifdef USE_ANISOTROPY
		float dotTL = dot( material.anisotropyT, lightDir );
		float dotTV = dot( material.anisotropyT, viewDir );
		float dotTH = dot( material.anisotropyT, halfDir );
		float dotBL = dot( material.anisotropyB, lightDir );
		float dotBV = dot( material.anisotropyB, viewDir );
		float dotBH = dot( material.anisotropyB, halfDir );
		float alphaT = max( material.alphaT, alpha );
		float V = V_GGX_SmithCorrelated_Anisotropic( alphaT, alpha, dotTV, dotBV, dotTL, dotBL, dotNV, dotNL );
		float D = D_GGX_Anisotropic( alphaT, alpha, dotNH, dotTH, dotBH );
	#else
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
	#endif
	return F * ( V * D );
}
vec2 LTC_Uv( const in vec3 N, const in vec3 V, const in float roughness ) {
	const float LUT_SIZE = 64.0;
	const float LUT_SCALE = ( LUT_SIZE - 1.0 ) / LUT_SIZE;
	const float LUT_BIAS = 0.5 / LUT_SIZE;
	float dotNV = saturate( dot( N, V ) );
	vec2 uv = vec2( roughness, sqrt( 1.0 - dotNV ) );
	uv = uv * LUT_SCALE + LUT_BIAS;
	return uv;
}
float LTC_ClippedSphereFormFactor( const in vec3 f ) {
	float l = length( f );
	return max( ( l * l + f.z ) / ( l + 1.0 ), 0.0 );
}
vec3 LTC_EdgeVectorFormFactor( const in vec3 v1, const in vec3 v2 ) {
	float x = dot( v1, v2 );
	float y = abs( x );
	float a = 0.8543985 + ( 0.4965155 + 0.0145206 * y ) * y;
	float b = 3.4175940 + ( 4.1616724 + y ) * y;
	float v = a / b;
	float theta_sintheta = ( x > 0.0 ) ? v : 0.5 * inversesqrt( max( 1.0 - x * x, 1e-7 ) ) - v;
	return cross( v1, v2 ) * theta_sintheta;
}
vec3 LTC_Evaluate( const in vec3 N, const in vec3 V, const in vec3 P, const in mat3 mInv, const in vec3 rectCoords[ 4 ] ) {
	vec3 v1 = rectCoords[ 1 ] - rectCoords[ 0 ];
	vec3 v2 = rectCoords[ 3 ] - rectCoords[ 0 ];
	vec3 lightNormal = cross( v1, v2 );
	if( dot( lightNormal, P - rectCoords[ 0 ] ) < 0.0 ) return vec3( 0.0 );
	vec3 T1, T2;
	T1 = normalize( V - N * dot( V, N ) );
	T2 = - cross( N, T1 );
	mat3 mat = mInv * transpose( mat3( T1, T2, N ) );
	vec3 coords[ 4 ];
	coords[ 0 ] = mat * ( rectCoords[ 0 ] - P );
	coords[ 1 ] = mat * ( rectCoords[ 1 ] - P );
	coords[ 2 ] = mat * ( rectCoords[ 2 ] - P );
	coords[ 3 ] = mat * ( rectCoords[ 3 ] - P );
	coords[ 0 ] = normalize( coords[ 0 ] );
	coords[ 1 ] = normalize( coords[ 1 ] );
	coords[ 2 ] = normalize( coords[ 2 ] );
	coords[ 3 ] = normalize( coords[ 3 ] );
	vec3 vectorFormFactor = vec3( 0.0 );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 0 ], coords[ 1 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 1 ], coords[ 2 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 2 ], coords[ 3 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 3 ], coords[ 0 ] );
	float result = LTC_ClippedSphereFormFactor( vectorFormFactor );
	return vec3( result );
}
#if defined( USE_SHEEN )
float D_Charlie( float roughness, float dotNH ) {
	float alpha = pow2( roughness );
	float invAlpha = 1.0 / alpha;
	float cos2h = dotNH * dotNH;
	float sin2h = max( 1.0 - cos2h, 0.0078125 );
	return ( 2.0 + invAlpha ) * pow( sin2h, invAlpha * 0.5 ) / ( 2.0 * PI );
}
float V_Neubelt( float dotNV, float dotNL ) {
	return saturate( 1.0 / ( 4.0 * ( dotNL + dotNV - dotNL * dotNV ) ) );
}
vec3 BRDF_Sheen( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, vec3 sheenColor, const in float sheenRoughness ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float D = D_Charlie( sheenRoughness, dotNH );
	float V = V_Neubelt( dotNV, dotNL );
	return sheenColor * ( D * V );
}
#endif
float IBLSheenBRDF( const in vec3 normal, const in vec3 viewDir, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	float r2 = roughness * roughness;
	float rInv = 1.0 / ( roughness + 0.1 );
	float a = -1.9362 + 1.0678 * roughness + 0.4573 * r2 - 0.8469 * rInv;
	float b = -0.6014 + 0.5538 * roughness - 0.4670 * r2 - 0.1255 * rInv;
	float DG = exp( a * dotNV + b );
	return saturate( DG );
}
vec3 EnvironmentBRDF( const in vec3 normal, const in vec3 viewDir, const in vec3 specularColor, const in float specularF90, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	vec2 fab = texture2D( dfgLUT, vec2( roughness, dotNV ) ).rg;
	return specularColor * fab.x + specularF90 * fab.y;
}
#ifdef USE_IRIDESCENCE
void computeMultiscatteringIridescence( const in vec2 fab, const in vec3 specularColor, const in float specularF90, const in float iridescence, const in vec3 iridescenceF0, inout vec3 singleScatter, inout vec3 multiScatter ) {
#else
void computeMultiscattering( const in vec2 fab, const in vec3 specularColor, const in float specularF90, inout vec3 singleScatter, inout vec3 multiScatter ) {
#endif
	#ifdef USE_IRIDESCENCE
		vec3 Fr = mix( specularColor, iridescenceF0, iridescence );
	#else
		vec3 Fr = specularColor;
	#endif
	vec3 FssEss = Fr * fab.x + specularF90 * fab.y;
	float Ess = fab.x + fab.y;
	float Ems = 1.0 - Ess;
	vec3 Favg = Fr + ( 1.0 - Fr ) * 0.047619;	vec3 Fms = FssEss * Favg / ( 1.0 - Ems * Favg );
	singleScatter += FssEss;
	multiScatter += Fms * Ems;
}
#if NUM_RECT_AREA_LIGHTS > 0
	void RE_Direct_RectArea_Physical( const in RectAreaLight rectAreaLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
		vec3 normal = geometryNormal;
		vec3 viewDir = geometryViewDir;
		vec3 position = geometryPosition;
		vec3 lightPos = rectAreaLight.position;
		vec3 halfWidth = rectAreaLight.halfWidth;
		vec3 halfHeight = rectAreaLight.halfHeight;
		vec3 lightColor = rectAreaLight.color;
		float roughness = material.roughness;
		vec3 rectCoords[ 4 ];
		rectCoords[ 0 ] = lightPos + halfWidth - halfHeight;		rectCoords[ 1 ] = lightPos - halfWidth - halfHeight;
		rectCoords[ 2 ] = lightPos - halfWidth + halfHeight;
		rectCoords[ 3 ] = lightPos + halfWidth + halfHeight;
		vec2 uv = LTC_Uv( normal, viewDir, roughness );
		vec4 t1 = texture2D( ltc_1, uv );
		vec4 t2 = texture2D( ltc_2, uv );
		mat3 mInv = mat3(
			vec3( t1.x, 0, t1.y ),
			vec3(    0, 1,    0 ),
			vec3( t1.z, 0, t1.w )
		);
		vec3 fresnel = ( material.specularColorBlended * t2.x + ( material.specularF90 - material.specularColorBlended ) * t2.y );
		reflectedLight.directSpecular += lightColor * fresnel * LTC_Evaluate( normal, viewDir, position, mInv, rectCoords );
		reflectedLight.directDiffuse += lightColor * material.diffuseContribution * LTC_Evaluate( normal, viewDir, position, mat3( 1.0 ), rectCoords );
		#ifdef USE_CLEARCOAT
			vec3 Ncc = geometryClearcoatNormal;
			vec2 uvClearcoat = LTC_Uv( Ncc, viewDir, material.clearcoatRoughness );
			vec4 t1Clearcoat = texture2D( ltc_1, uvClearcoat );
			vec4 t2Clearcoat = texture2D( ltc_2, uvClearcoat );
			mat3 mInvClearcoat = mat3(
				vec3( t1Clearcoat.x, 0, t1Clearcoat.y ),
				vec3(             0, 1,             0 ),
				vec3( t1Clearcoat.z, 0, t1Clearcoat.w )
			);
			vec3 fresnelClearcoat = material.clearcoatF0 * t2Clearcoat.x + ( material.clearcoatF90 - material.clearcoatF0 ) * t2Clearcoat.y;
			clearcoatSpecularDirect += lightColor * fresnelClearcoat * LTC_Evaluate( Ncc, viewDir, position, mInvClearcoat, rectCoords );
		#endif
	}
#endif
void RE_Direct_Physical( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	#ifdef USE_CLEARCOAT
		float dotNLcc = saturate( dot( geometryClearcoatNormal, directLight.direction ) );
		vec3 ccIrradiance = dotNLcc * directLight.color;
		clearcoatSpecularDirect += ccIrradiance * BRDF_GGX_Clearcoat( directLight.direction, geometryViewDir, geometryClearcoatNormal, material );
	#endif
	#ifdef USE_SHEEN
 
 		sheenSpecularDirect += irradiance * BRDF_Sheen( directLight.direction, geometryViewDir, geometryNormal, material.sheenColor, material.sheenRoughness );
 
 		float sheenAlbedoV = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
 		float sheenAlbedoL = IBLSheenBRDF( geometryNormal, directLight.direction, material.sheenRoughness );
 
 		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * max( sheenAlbedoV, sheenAlbedoL );
 
 		irradiance *= sheenEnergyComp;
 
 	#endif
	vec3 specularBRDF = BRDF_GGX( directLight.direction, geometryViewDir, geometryNormal, material );
	#ifdef USE_RETROREFLECTION
		vec3 retroViewDir = reflect( - geometryViewDir, geometryNormal );
		vec3 retroSpecularBRDF = BRDF_GGX( directLight.direction, retroViewDir, geometryNormal, material );
		specularBRDF = mix( specularBRDF, retroSpecularBRDF, saturate( material.retroreflectivity ) );
	#endif
	reflectedLight.directSpecular += irradiance * specularBRDF * material.multiScatteringCompensation;
	vec3 halfDir = normalize( directLight.direction + geometryViewDir );
	float dotVH = saturate( dot( geometryViewDir, halfDir ) );
	vec3 F = F_Schlick( material.specularColor, material.specularF90, dotVH );
	#ifdef USE_RETROREFLECTION
		vec3 retroHalfDir = normalize( directLight.direction + retroViewDir );
		float dotRetroVH = saturate( dot( retroViewDir, retroHalfDir ) );
		vec3 retroF = F_Schlick( material.specularColor, material.specularF90, dotRetroVH );
		F = mix( F, retroF, saturate( material.retroreflectivity ) );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		vec3 diffuseBRDF = BRDF_EON( directLight.direction, geometryViewDir, geometryNormal, material.diffuseColor, material.diffuseRoughness ) * ( 1.0 - material.metalness );
	#else
		vec3 diffuseBRDF = BRDF_Lambert( material.diffuseContribution );
	#endif
	reflectedLight.directDiffuse += irradiance * diffuseBRDF * ( 1.0 - F );
}
void RE_IndirectDiffuse_Physical( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 singleScattering = vec3( 0.0 );
	vec3 multiScattering = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScattering, multiScattering );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScattering, multiScattering );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuseAlbedo = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness );
		vec3 diffuse = irradiance * RECIPROCAL_PI * diffuseAlbedo * ( 1.0 - singleScattering - multiScattering );
	#else
		vec3 diffuse = irradiance * BRDF_Lambert( material.diffuseContribution ) * ( 1.0 - singleScattering - multiScattering );
	#endif
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		sheenSpecularIndirect += irradiance * material.sheenColor * sheenAlbedo * RECIPROCAL_PI;
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		diffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectDiffuse += diffuse;
}
void RE_IndirectSpecular_Physical( const in vec3 radiance, const in vec3 irradiance, const in vec3 clearcoatRadiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
	#ifdef USE_CLEARCOAT
		clearcoatSpecularIndirect += clearcoatRadiance * EnvironmentBRDF( geometryClearcoatNormal, geometryViewDir, material.clearcoatF0, material.clearcoatF90, material.clearcoatRoughness );
	#endif
	#ifdef USE_SHEEN
		sheenSpecularIndirect += irradiance * material.sheenColor * IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness ) * RECIPROCAL_PI;
 	#endif
	vec3 singleScatteringDielectric = vec3( 0.0 );
	vec3 multiScatteringDielectric = vec3( 0.0 );
	vec3 singleScatteringMetallic = vec3( 0.0 );
	vec3 multiScatteringMetallic = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscatteringIridescence( material.dfg, material.diffuseColor, material.specularF90, material.iridescence, material.iridescenceF0Metallic, singleScatteringMetallic, multiScatteringMetallic );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscattering( material.dfg, material.diffuseColor, material.specularF90, singleScatteringMetallic, multiScatteringMetallic );
	#endif
	vec3 singleScattering = mix( singleScatteringDielectric, singleScatteringMetallic, material.metalness );
	vec3 multiScattering = mix( multiScatteringDielectric, multiScatteringMetallic, material.metalness );
	vec3 totalScatteringDielectric = singleScatteringDielectric + multiScatteringDielectric;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuse = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness ) * ( 1.0 - totalScatteringDielectric );
	#else
		vec3 diffuse = material.diffuseContribution * ( 1.0 - totalScatteringDielectric );
	#endif
	vec3 cosineWeightedIrradiance = irradiance * RECIPROCAL_PI;
	vec3 indirectSpecular = radiance * singleScattering;
	indirectSpecular += multiScattering * cosineWeightedIrradiance;
	vec3 indirectDiffuse = diffuse * cosineWeightedIrradiance;
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		indirectSpecular *= sheenEnergyComp;
		indirectDiffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectSpecular += indirectSpecular;
	reflectedLight.indirectDiffuse += indirectDiffuse;
}
#define RE_Direct				RE_Direct_Physical
#define RE_Direct_RectArea		RE_Direct_RectArea_Physical
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Physical
#define RE_IndirectSpecular		RE_IndirectSpecular_Physical
float computeSpecularOcclusion( const in float dotNV, const in float ambientOcclusion, const in float roughness ) {
	return saturate( pow( dotNV + ambientOcclusion, exp2( - 16.0 * roughness - 1.0 ) ) - 1.0 + ambientOcclusion );
}`,Wx=`
vec3 geometryPosition = - vViewPosition;
vec3 geometryNormal = normal;
vec3 geometryViewDir = ( isOrthographic ) ? vec3( 0, 0, 1 ) : normalize( vViewPosition );
vec3 geometryClearcoatNormal = vec3( 0.0 );
#ifdef USE_CLEARCOAT
	geometryClearcoatNormal = clearcoatNormal;
#endif
#ifdef USE_IRIDESCENCE
	float dotNVi = saturate( dot( normal, geometryViewDir ) );
	if ( material.iridescenceThickness == 0.0 ) {
		material.iridescence = 0.0;
	} else {
		material.iridescence = saturate( material.iridescence );
	}
	if ( material.iridescence > 0.0 ) {
		vec3 iridescenceFresnelDielectric = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.specularColor );
		vec3 iridescenceFresnelMetallic = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.diffuseColor );
		material.iridescenceFresnel = mix( iridescenceFresnelDielectric, iridescenceFresnelMetallic, material.metalness );
		material.iridescenceF0Dielectric = Schlick_to_F0( iridescenceFresnelDielectric, 1.0, dotNVi );
		material.iridescenceF0Metallic = Schlick_to_F0( iridescenceFresnelMetallic, 1.0, dotNVi );
	}
#endif
#ifdef STANDARD
	float dotNVms = saturate( dot( geometryNormal, geometryViewDir ) );
	material.dfg = texture2D( dfgLUT, vec2( material.roughness, dotNVms ) ).rg;
	#if ( NUM_SUN_LIGHTS > 0 || NUM_DIR_LIGHTS > 0 || NUM_POINT_LIGHTS > 0 || NUM_SPOT_LIGHTS > 0 )
		float EssMs = material.dfg.x + material.dfg.y;
		material.multiScatteringCompensation = 1.0 + material.specularColorBlended * ( 1.0 / EssMs - 1.0 );
	#endif
#endif
IncidentLight directLight;
#if ( NUM_POINT_LIGHTS > 0 ) && defined( RE_Direct )
	PointLight pointLight;
	#if defined( USE_SHADOWMAP ) && NUM_POINT_LIGHT_SHADOWS > 0
	PointLightShadow pointLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHTS; i ++ ) {
		pointLight = pointLights[ i ];
		getPointLightInfo( pointLight, geometryPosition, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_POINT_LIGHT_SHADOWS ) && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
		pointLightShadow = pointLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getPointShadow( pointShadowMap[ i ], pointLightShadow.shadowMapSize, pointLightShadow.shadowIntensity, pointLightShadow.shadowBias, pointLightShadow.shadowRadius, vPointShadowCoord[ i ], pointLightShadow.shadowCameraNear, pointLightShadow.shadowCameraFar ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SPOT_LIGHTS > 0 ) && defined( RE_Direct )
	SpotLight spotLight;
	vec4 spotColor;
	vec3 spotLightCoord;
	bool inSpotLightMap;
	#if defined( USE_SHADOWMAP ) && NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHTS; i ++ ) {
		spotLight = spotLights[ i ];
		getSpotLightInfo( spotLight, geometryPosition, directLight );
		#if ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#define SPOT_LIGHT_MAP_INDEX UNROLLED_LOOP_INDEX
		#elif ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		#define SPOT_LIGHT_MAP_INDEX NUM_SPOT_LIGHT_MAPS
		#else
		#define SPOT_LIGHT_MAP_INDEX ( UNROLLED_LOOP_INDEX - NUM_SPOT_LIGHT_SHADOWS + NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#endif
		#if ( SPOT_LIGHT_MAP_INDEX < NUM_SPOT_LIGHT_MAPS )
			spotLightCoord = vSpotLightCoord[ i ].xyz / vSpotLightCoord[ i ].w;
			inSpotLightMap = all( lessThan( abs( spotLightCoord * 2. - 1. ), vec3( 1.0 ) ) );
			spotColor = texture2D( spotLightMap[ SPOT_LIGHT_MAP_INDEX ], spotLightCoord.xy );
			directLight.color = inSpotLightMap ? directLight.color * spotColor.rgb : directLight.color;
		#endif
		#undef SPOT_LIGHT_MAP_INDEX
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		spotLightShadow = spotLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( spotShadowMap[ i ], spotLightShadow.shadowMapSize, spotLightShadow.shadowIntensity, spotLightShadow.shadowBias, spotLightShadow.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SUN_LIGHTS > 0 ) && defined( RE_Direct )
	SunLight sunLight;
	#if defined( USE_SHADOWMAP ) && NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHTS; i ++ ) {
		sunLight = sunLights[ i ];
		getSunLightInfo( sunLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SUN_LIGHT_SHADOWS )
		sunLightShadow = sunLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getSunShadow( sunShadowMap[ i ], sunLightShadow, UNROLLED_LOOP_INDEX ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_DIR_LIGHTS > 0 ) && defined( RE_Direct )
	DirectionalLight directionalLight;
	#if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHTS; i ++ ) {
		directionalLight = directionalLights[ i ];
		getDirectionalLightInfo( directionalLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_DIR_LIGHT_SHADOWS )
		directionalLightShadow = directionalLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( directionalShadowMap[ i ], directionalLightShadow.shadowMapSize, directionalLightShadow.shadowIntensity, directionalLightShadow.shadowBias, directionalLightShadow.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_RECT_AREA_LIGHTS > 0 ) && defined( RE_Direct_RectArea )
	RectAreaLight rectAreaLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_RECT_AREA_LIGHTS; i ++ ) {
		rectAreaLight = rectAreaLights[ i ];
		RE_Direct_RectArea( rectAreaLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if defined( RE_IndirectDiffuse )
	vec3 iblIrradiance = vec3( 0.0 );
	vec3 irradiance = getAmbientLightIrradiance( ambientLightColor );
	#if defined( USE_LIGHT_PROBES )
		irradiance += getLightProbeIrradiance( lightProbe, geometryNormal );
	#endif
	#if ( NUM_HEMI_LIGHTS > 0 )
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_HEMI_LIGHTS; i ++ ) {
			irradiance += getHemisphereLightIrradiance( hemisphereLights[ i ], geometryNormal );
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_LIGHT_PROBE_GRIDS > 0
		vec3 probeWorldPos = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
		vec3 probeWorldNormal = transformNormalByInverseViewMatrix( geometryNormal, viewMatrix );
		int probeGrid = - 1;
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( isInsideLightProbeGrid( probeWorldPos, probeWorldNormal, probesMin[ i ], probesMax[ i ], probesResolution[ i ] ) ) probeGrid = UNROLLED_LOOP_INDEX;
		}
		#pragma unroll_loop_end
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( probeGrid == UNROLLED_LOOP_INDEX ) irradiance += getLightProbeGridIrradiance( probesSH[ i ], probesMin[ i ], probesMax[ i ], probesResolution[ i ], probeWorldPos, probeWorldNormal );
		}
		#pragma unroll_loop_end
	#endif
#endif
#if defined( RE_IndirectSpecular )
	vec3 radiance = vec3( 0.0 );
	vec3 clearcoatRadiance = vec3( 0.0 );
#endif`,$x=`#if defined( RE_IndirectDiffuse )
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		vec3 lightMapIrradiance = lightMapTexel.rgb * lightMapIntensity;
		irradiance += lightMapIrradiance;
	#endif
	#if defined( USE_ENVMAP ) && defined( ENVMAP_TYPE_PMREM )
		#if defined( STANDARD ) || defined( LAMBERT ) || defined( PHONG )
			iblIrradiance += getIBLIrradiance( geometryNormal );
		#endif
	#endif
#endif
#if defined( USE_ENVMAP ) && defined( RE_IndirectSpecular )
	#ifdef USE_ANISOTROPY
		vec3 iblRadiance = getIBLAnisotropyRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
	#else
		vec3 iblRadiance = getIBLRadiance( geometryViewDir, geometryNormal, material.roughness );
	#endif
	#ifdef USE_RETROREFLECTION
		#ifdef USE_ANISOTROPY
			vec3 retroIBLRadiance = getIBLAnisotropyRetroRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
		#else
			vec3 retroIBLRadiance = getIBLRetroRadiance( geometryViewDir, geometryNormal, material.roughness );
		#endif
		iblRadiance = mix( iblRadiance, retroIBLRadiance, saturate( material.retroreflectivity ) );
	#endif
	radiance += iblRadiance;
	#ifdef USE_CLEARCOAT
		clearcoatRadiance += getIBLRadiance( geometryViewDir, geometryClearcoatNormal, material.clearcoatRoughness );
	#endif
#endif`,Xx=`#if defined( RE_IndirectDiffuse )
	#if defined( LAMBERT ) || defined( PHONG )
		irradiance += iblIrradiance;
	#endif
	RE_IndirectDiffuse( irradiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif
#if defined( RE_IndirectSpecular )
	RE_IndirectSpecular( radiance, iblIrradiance, clearcoatRadiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif`,qx=`#if NUM_LIGHT_PROBE_GRIDS > 0
uniform highp sampler3D probesSH[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMin[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMax[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesResolution[ NUM_LIGHT_PROBE_GRIDS ];
bool isInsideLightProbeGrid( vec3 worldPos, vec3 worldNormal, vec3 probesMin, vec3 probesMax, vec3 probesResolution ) {
	vec3 spacing = ( probesMax - probesMin ) / probesResolution;
	vec3 samplePos = worldPos + worldNormal * spacing * 0.5;
	vec3 margin = spacing * 0.01;
	return all( greaterThanEqual( samplePos, probesMin - margin ) ) && all( lessThanEqual( samplePos, probesMax + margin ) );
}
vec3 getLightProbeGridIrradiance( highp sampler3D probesSH, vec3 probesMin, vec3 probesMax, vec3 probesResolution, vec3 worldPos, vec3 worldNormal ) {
	vec3 res = probesResolution;
	vec3 gridRange = probesMax - probesMin;
	vec3 probeSpacing = gridRange / res;
	vec3 samplePos = worldPos + worldNormal * probeSpacing * 0.5;
	vec3 uvw = clamp( ( samplePos - probesMin ) / gridRange, 0.5 / res, 1.0 - 0.5 / res );
	float nz          = res.z;
	float paddedSlices = nz + 2.0;
	float atlasDepth  = 7.0 * paddedSlices;
	float uvZBase     = uvw.z * nz + 1.0;
	vec4 s0 = texture( probesSH, vec3( uvw.xy, ( uvZBase                       ) / atlasDepth ) );
	vec4 s1 = texture( probesSH, vec3( uvw.xy, ( uvZBase +       paddedSlices   ) / atlasDepth ) );
	vec4 s2 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 2.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s3 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 3.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s4 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 4.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s5 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 5.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s6 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 6.0 * paddedSlices   ) / atlasDepth ) );
	vec3 c0 = s0.xyz;
	vec3 c1 = vec3( s0.w, s1.xy );
	vec3 c2 = vec3( s1.zw, s2.x );
	vec3 c3 = s2.yzw;
	vec3 c4 = s3.xyz;
	vec3 c5 = vec3( s3.w, s4.xy );
	vec3 c6 = vec3( s4.zw, s5.x );
	vec3 c7 = s5.yzw;
	vec3 c8 = s6.xyz;
	float x = worldNormal.x, y = worldNormal.y, z = worldNormal.z;
	vec3 result = c0 * 0.886227;
	result += c1 * 2.0 * 0.511664 * y;
	result += c2 * 2.0 * 0.511664 * z;
	result += c3 * 2.0 * 0.511664 * x;
	result += c4 * 2.0 * 0.429043 * x * y;
	result += c5 * 2.0 * 0.429043 * y * z;
	result += c6 * ( 0.743125 * z * z - 0.247708 );
	result += c7 * 2.0 * 0.429043 * x * z;
	result += c8 * 0.429043 * ( x * x - y * y );
	return max( result, vec3( 0.0 ) );
}
#endif`,Yx=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	gl_FragDepth = vIsPerspective == 0.0 ? gl_FragCoord.z : log2( vFragDepth ) * logDepthBufFC * 0.5;
#endif`,jx=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	uniform float logDepthBufFC;
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,Zx=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,Kx=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	vFragDepth = 1.0 + gl_Position.w;
	vIsPerspective = float( isPerspectiveMatrix( projectionMatrix ) );
#endif`,Jx=`#ifdef USE_MAP
	vec4 sampledDiffuseColor = texture2D( map, vMapUv );
	#ifdef DECODE_VIDEO_TEXTURE
		sampledDiffuseColor = sRGBTransferEOTF( sampledDiffuseColor );
	#endif
	diffuseColor *= sampledDiffuseColor;
#endif`,Qx=`#ifdef USE_MAP
	uniform sampler2D map;
#endif`,t_=`#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
	#if defined( USE_POINTS_UV )
		vec2 uv = vUv;
	#else
		vec2 uv = ( uvTransform * vec3( gl_PointCoord.x, 1.0 - gl_PointCoord.y, 1 ) ).xy;
	#endif
#endif
#ifdef USE_MAP
	diffuseColor *= texture2D( map, uv );
#endif
#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, uv ).g;
#endif`,e_=`#if defined( USE_POINTS_UV )
	varying vec2 vUv;
#else
	#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
		uniform mat3 uvTransform;
	#endif
#endif
#ifdef USE_MAP
	uniform sampler2D map;
#endif
#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,n_=`float metalnessFactor = metalness;
#ifdef USE_METALNESSMAP
	vec4 texelMetalness = texture2D( metalnessMap, vMetalnessMapUv );
	metalnessFactor *= texelMetalness.b;
#endif`,i_=`#ifdef USE_METALNESSMAP
	uniform sampler2D metalnessMap;
#endif`,s_=`#ifdef USE_INSTANCING_MORPH
	float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	float morphTargetBaseInfluence = texelFetch( morphTexture, ivec2( 0, gl_InstanceID ), 0 ).r;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		morphTargetInfluences[i] =  texelFetch( morphTexture, ivec2( i + 1, gl_InstanceID ), 0 ).r;
	}
#endif`,r_=`#if defined( USE_MORPHCOLORS )
	#if defined( USE_COLOR_ALPHA )
		vColor *= morphTargetBaseInfluence;
	#elif defined( USE_COLOR )
		vColor.rgb *= morphTargetBaseInfluence;
	#endif
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		#if defined( USE_COLOR_ALPHA )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor += getMorph( gl_VertexID, i, 2 ) * morphTargetInfluences[ i ];
		#elif defined( USE_COLOR )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor.rgb += getMorph( gl_VertexID, i, 2 ).rgb * morphTargetInfluences[ i ];
		#endif
	}
#endif`,o_=`#ifdef USE_MORPHNORMALS
	objectNormal *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) objectNormal += getMorph( gl_VertexID, i, 1 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,a_=`#ifdef USE_MORPHTARGETS
	#ifndef USE_INSTANCING_MORPH
		uniform float morphTargetBaseInfluence;
		uniform float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	#endif
	uniform sampler2DArray morphTargetsTexture;
	uniform ivec2 morphTargetsTextureSize;
	vec4 getMorph( const in int vertexIndex, const in int morphTargetIndex, const in int offset ) {
		int texelIndex = vertexIndex * MORPHTARGETS_TEXTURE_STRIDE + offset;
		int y = texelIndex / morphTargetsTextureSize.x;
		int x = texelIndex - y * morphTargetsTextureSize.x;
		ivec3 morphUV = ivec3( x, y, morphTargetIndex );
		return texelFetch( morphTargetsTexture, morphUV, 0 );
	}
#endif`,l_=`#ifdef USE_MORPHTARGETS
	transformed *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) transformed += getMorph( gl_VertexID, i, 0 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,c_=`float faceDirection = gl_FrontFacing ? 1.0 : - 1.0;
#ifdef FLAT_SHADED
	vec3 fdx = dFdx( vViewPosition );
	vec3 fdy = dFdy( vViewPosition );
	vec3 normal = normalize( cross( fdx, fdy ) );
#else
	vec3 normal = normalize( vNormal );
	#ifdef DOUBLE_SIDED
		normal *= faceDirection;
	#endif
#endif
#if defined( USE_NORMALMAP_TANGENTSPACE ) || defined( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY )
	#ifdef USE_TANGENT
		mat3 tbn = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn = getTangentFrame( - vViewPosition, normal,
		#if defined( USE_NORMALMAP )
			vNormalMapUv
		#elif defined( USE_CLEARCOAT_NORMALMAP )
			vClearcoatNormalMapUv
		#else
			vUv
		#endif
		);
	#endif
	#ifdef DOUBLE_SIDED
		tbn[0] *= faceDirection;
		tbn[1] *= faceDirection;
	#endif
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	#ifdef USE_TANGENT
		mat3 tbn2 = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn2 = getTangentFrame( - vViewPosition, normal, vClearcoatNormalMapUv );
	#endif
	#ifdef DOUBLE_SIDED
		tbn2[0] *= faceDirection;
		tbn2[1] *= faceDirection;
	#endif
#endif
vec3 nonPerturbedNormal = normal;`,h_=`#ifdef USE_NORMALMAP_OBJECTSPACE
	normal = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#ifdef FLIP_SIDED
		normal = - normal;
	#endif
	#ifdef DOUBLE_SIDED
		normal = normal * faceDirection;
	#endif
	normal = normalize( normalMatrix * normal );
#elif defined( USE_NORMALMAP_TANGENTSPACE )
	vec3 mapN = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#if defined( USE_PACKED_NORMALMAP )
		mapN = vec3( mapN.xy, sqrt( saturate( 1.0 - dot( mapN.xy, mapN.xy ) ) ) );
	#endif
	mapN.xy *= normalScale;
	normal = normalize( tbn * mapN );
#elif defined( USE_BUMPMAP )
	normal = perturbNormalArb( - vViewPosition, normal, dHdxy_fwd(), faceDirection );
#endif`,u_=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,d_=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,f_=`#ifndef FLAT_SHADED
	vNormal = normalize( transformedNormal );
	#ifdef USE_TANGENT
		vTangent = normalize( transformedTangent );
		vBitangent = normalize( cross( vNormal, vTangent ) * tangent.w );
		#ifdef FLIP_SIDED
			vBitangent = - vBitangent;
		#endif
	#endif
#endif`,p_=`#ifdef USE_NORMALMAP
	uniform sampler2D normalMap;
	uniform vec2 normalScale;
#endif
#ifdef USE_NORMALMAP_OBJECTSPACE
	uniform mat3 normalMatrix;
#endif
#if ! defined ( USE_TANGENT ) && ( defined ( USE_NORMALMAP_TANGENTSPACE ) || defined ( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY ) )
	mat3 getTangentFrame( vec3 eye_pos, vec3 surf_norm, vec2 uv ) {
		vec3 q0 = dFdx( eye_pos.xyz );
		vec3 q1 = dFdy( eye_pos.xyz );
		vec2 st0 = dFdx( uv.st );
		vec2 st1 = dFdy( uv.st );
		vec3 N = surf_norm;
		vec3 q1perp = cross( q1, N );
		vec3 q0perp = cross( N, q0 );
		vec3 T = q1perp * st0.x + q0perp * st1.x;
		vec3 B = q1perp * st0.y + q0perp * st1.y;
		float det = max( dot( T, T ), dot( B, B ) );
		float scale = ( det == 0.0 ) ? 0.0 : inversesqrt( det );
		return mat3( T * scale, B * scale, N );
	}
#endif`,m_=`#ifdef USE_CLEARCOAT
	vec3 clearcoatNormal = nonPerturbedNormal;
#endif`,g_=`#ifdef USE_CLEARCOAT_NORMALMAP
	vec3 clearcoatMapN = texture2D( clearcoatNormalMap, vClearcoatNormalMapUv ).xyz * 2.0 - 1.0;
	clearcoatMapN.xy *= clearcoatNormalScale;
	clearcoatNormal = normalize( tbn2 * clearcoatMapN );
#endif`,v_=`#ifdef USE_CLEARCOATMAP
	uniform sampler2D clearcoatMap;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform sampler2D clearcoatNormalMap;
	uniform vec2 clearcoatNormalScale;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform sampler2D clearcoatRoughnessMap;
#endif`,x_=`#ifdef USE_IRIDESCENCEMAP
	uniform sampler2D iridescenceMap;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform sampler2D iridescenceThicknessMap;
#endif`,__=`#ifdef OPAQUE
diffuseColor.a = 1.0;
#endif
#ifdef USE_TRANSMISSION
diffuseColor.a *= material.transmissionAlpha;
#endif
gl_FragColor = vec4( outgoingLight, diffuseColor.a );`,y_=`vec3 packNormalToRGB( const in vec3 normal ) {
	return normalize( normal ) * 0.5 + 0.5;
}
vec3 unpackRGBToNormal( const in vec3 rgb ) {
	return 2.0 * rgb.xyz - 1.0;
}
const float PackUpscale = 256. / 255.;const float UnpackDownscale = 255. / 256.;const float ShiftRight8 = 1. / 256.;
const float Inv255 = 1. / 255.;
const vec4 PackFactors = vec4( 1.0, 256.0, 256.0 * 256.0, 256.0 * 256.0 * 256.0 );
const vec2 UnpackFactors2 = vec2( UnpackDownscale, 1.0 / PackFactors.g );
const vec3 UnpackFactors3 = vec3( UnpackDownscale / PackFactors.rg, 1.0 / PackFactors.b );
const vec4 UnpackFactors4 = vec4( UnpackDownscale / PackFactors.rgb, 1.0 / PackFactors.a );
vec4 packDepthToRGBA( const in float v ) {
	if( v <= 0.0 )
		return vec4( 0., 0., 0., 0. );
	if( v >= 1.0 )
		return vec4( 1., 1., 1., 1. );
	float vuf;
	float af = modf( v * PackFactors.a, vuf );
	float bf = modf( vuf * ShiftRight8, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec4( vuf * Inv255, gf * PackUpscale, bf * PackUpscale, af );
}
vec3 packDepthToRGB( const in float v ) {
	if( v <= 0.0 )
		return vec3( 0., 0., 0. );
	if( v >= 1.0 )
		return vec3( 1., 1., 1. );
	float vuf;
	float bf = modf( v * PackFactors.b, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec3( vuf * Inv255, gf * PackUpscale, bf );
}
vec2 packDepthToRG( const in float v ) {
	if( v <= 0.0 )
		return vec2( 0., 0. );
	if( v >= 1.0 )
		return vec2( 1., 1. );
	float vuf;
	float gf = modf( v * 256., vuf );
	return vec2( vuf * Inv255, gf );
}
float unpackRGBAToDepth( const in vec4 v ) {
	return dot( v, UnpackFactors4 );
}
float unpackRGBToDepth( const in vec3 v ) {
	return dot( v, UnpackFactors3 );
}
float unpackRGToDepth( const in vec2 v ) {
	return v.r * UnpackFactors2.r + v.g * UnpackFactors2.g;
}
vec4 pack2HalfToRGBA( const in vec2 v ) {
	vec4 r = vec4( v.x, fract( v.x * 255.0 ), v.y, fract( v.y * 255.0 ) );
	return vec4( r.x - r.y / 255.0, r.y, r.z - r.w / 255.0, r.w );
}
vec2 unpackRGBATo2Half( const in vec4 v ) {
	return vec2( v.x + ( v.y / 255.0 ), v.z + ( v.w / 255.0 ) );
}
float viewZToOrthographicDepth( const in float viewZ, const in float near, const in float far ) {
	return ( viewZ + near ) / ( near - far );
}
float orthographicDepthToViewZ( const in float depth, const in float near, const in float far ) {
	#ifdef USE_REVERSED_DEPTH_BUFFER
	
		return depth * ( far - near ) - far;
	#else
		return depth * ( near - far ) - near;
	#endif
}
float viewZToPerspectiveDepth( const in float viewZ, const in float near, const in float far ) {
	return ( ( near + viewZ ) * far ) / ( ( far - near ) * viewZ );
}
float perspectiveDepthToViewZ( const in float depth, const in float near, const in float far ) {
	
	#ifdef USE_REVERSED_DEPTH_BUFFER
		return ( near * far ) / ( ( near - far ) * depth - near );
	#else
		return ( near * far ) / ( ( far - near ) * depth - far );
	#endif
}`,b_=`#ifdef PREMULTIPLIED_ALPHA
	gl_FragColor.rgb *= gl_FragColor.a;
#endif`,S_=`vec4 mvPosition = vec4( transformed, 1.0 );
#ifdef USE_BATCHING
	mvPosition = batchingMatrix * mvPosition;
#endif
#ifdef USE_INSTANCING
	mvPosition = instanceMatrix * mvPosition;
#endif
mvPosition = modelViewMatrix * mvPosition;
gl_Position = projectionMatrix * mvPosition;`,M_=`#ifdef DITHERING
	gl_FragColor.rgb = dithering( gl_FragColor.rgb );
#endif`,w_=`#ifdef DITHERING
	vec3 dithering( vec3 color ) {
		float grid_position = rand( gl_FragCoord.xy );
		vec3 dither_shift_RGB = vec3( 0.25 / 255.0, -0.25 / 255.0, 0.25 / 255.0 );
		dither_shift_RGB = mix( 2.0 * dither_shift_RGB, -2.0 * dither_shift_RGB, grid_position );
		return color + dither_shift_RGB;
	}
#endif`,E_=`float roughnessFactor = roughness;
#ifdef USE_ROUGHNESSMAP
	vec4 texelRoughness = texture2D( roughnessMap, vRoughnessMapUv );
	roughnessFactor *= texelRoughness.g;
#endif`,A_=`#ifdef USE_ROUGHNESSMAP
	uniform sampler2D roughnessMap;
#endif`,T_=`#if NUM_SPOT_LIGHT_COORDS > 0
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#if NUM_SPOT_LIGHT_MAPS > 0
	uniform sampler2D spotLightMap[ NUM_SPOT_LIGHT_MAPS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		#define SUN_LIGHT_CASCADES 2
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#else
			uniform sampler2D sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#endif
		uniform mat4 sunShadowMatrix[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		uniform vec4 sunShadowCascade[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
		struct SunLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SunLightShadow sunLightShadows[ NUM_SUN_LIGHT_SHADOWS ];
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#else
			uniform sampler2D directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#endif
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#else
			uniform sampler2D spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#endif
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform samplerCubeShadow pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#elif defined( SHADOWMAP_TYPE_BASIC )
			uniform samplerCube pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#endif
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float interleavedGradientNoise( vec2 position ) {
			return fract( 52.9829189 * fract( dot( position, vec2( 0.06711056, 0.00583715 ) ) ) );
		}
		vec2 vogelDiskSample( int sampleIndex, int samplesCount, float phi ) {
			const float goldenAngle = 2.399963229728653;
			float r = sqrt( ( float( sampleIndex ) + 0.5 ) / float( samplesCount ) );
			float theta = float( sampleIndex ) * goldenAngle + phi;
			return vec2( cos( theta ), sin( theta ) ) * r;
		}
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float getShadow( sampler2DShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 texelSize = vec2( 1.0 ) / shadowMapSize;
				vec2 radius = shadowRadius * texelSize;
				float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
				shadow = (
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 0, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 1, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 2, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 3, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 4, 5, phi ) * radius, shadowCoord.z ) )
				) * 0.2;
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#elif defined( SHADOWMAP_TYPE_VSM )
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 distribution = texture2D( shadowMap, shadowCoord.xy ).rg;
				float mean = distribution.x;
				float variance = distribution.y * distribution.y;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					float hard_shadow = step( mean, shadowCoord.z );
				#else
					float hard_shadow = step( shadowCoord.z, mean );
				#endif
				
				if ( hard_shadow == 1.0 ) {
					shadow = 1.0;
				} else {
					variance = max( variance, 0.0000001 );
					float d = shadowCoord.z - mean;
					float p_max = variance / ( variance + d * d );
					p_max = clamp( ( p_max - 0.3 ) / 0.65, 0.0, 1.0 );
					shadow = max( hard_shadow, p_max );
				}
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#else
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				float depth = texture2D( shadowMap, shadowCoord.xy ).r;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					shadow = step( depth, shadowCoord.z );
				#else
					shadow = step( shadowCoord.z, depth );
				#endif
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#endif
	#if NUM_SUN_LIGHT_SHADOWS > 0
		float getSunShadow(
			#if defined( SHADOWMAP_TYPE_PCF )
				sampler2DShadow shadowMap,
			#else
				sampler2D shadowMap,
			#endif
			SunLightShadow sunLightShadow,
			int shadowIndex
		) {
			vec4 shadowWorldPosition = vec4( vSunShadowWorldPosition.xyz + vSunShadowWorldNormal * sunLightShadow.shadowNormalBias, 1.0 );
			float viewDepth = vSunShadowWorldPosition.w;
			int cascadeOffset = shadowIndex * SUN_LIGHT_CASCADES;
			float shadow = 1.0;
			for ( int i = SUN_LIGHT_CASCADES - 1; i >= 0; i -- ) {
				vec4 cascade = sunShadowCascade[ cascadeOffset + i ];
				if ( viewDepth >= cascade.x && viewDepth < cascade.y ) {
					float cascadeShadow = getShadow(
						shadowMap,
						sunLightShadow.shadowMapSize,
						sunLightShadow.shadowIntensity,
						sunLightShadow.shadowBias,
						sunLightShadow.shadowRadius,
						sunShadowMatrix[ cascadeOffset + i ] * shadowWorldPosition
					);
					shadow = mix( cascadeShadow, shadow, smoothstep( cascade.z, cascade.y, viewDepth ) );
				}
			}
			return shadow;
		}
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
	#if defined( SHADOWMAP_TYPE_PCF )
	float getPointShadow( samplerCubeShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 bd3D = normalize( lightToPosition );
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float lightDistance = length( lightToPosition );
			float depthRange = shadowCameraFar - shadowCameraNear;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				float depthA = - shadowCameraNear / depthRange - shadowBias;
				float depthB = shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#else
				float depthA = shadowCameraFar / depthRange + shadowBias;
				float depthB = - shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#endif
			float texelSize = shadowRadius / shadowMapSize.x;
			vec3 absDir = abs( bd3D );
			vec3 tangent = absDir.x > absDir.z ? vec3( 0.0, 1.0, 0.0 ) : vec3( 1.0, 0.0, 0.0 );
			tangent = normalize( cross( bd3D, tangent ) );
			vec3 bitangent = cross( bd3D, tangent );
			float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
			shadow = 0.0;
			for ( int i = 0; i < 5; i ++ ) {
				vec2 offset = vogelDiskSample( i, 5, phi );
				vec3 direction = bd3D + ( tangent * offset.x + bitangent * offset.y ) * texelSize;
				vec3 absDirection = abs( direction );
				float dp = depthA + depthB / max( max( absDirection.x, absDirection.y ), absDirection.z );
				shadow += texture( shadowMap, vec4( direction, dp ) );
			}
			shadow *= 0.2;
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#elif defined( SHADOWMAP_TYPE_BASIC )
	float getPointShadow( samplerCube shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float dp = ( shadowCameraFar * ( viewSpaceZ - shadowCameraNear ) ) / ( viewSpaceZ * ( shadowCameraFar - shadowCameraNear ) );
			dp += shadowBias;
			vec3 bd3D = normalize( lightToPosition );
			float depth = textureCube( shadowMap, bd3D ).r;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				depth = 1.0 - depth;
			#endif
			shadow = step( dp, depth );
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#endif
	#endif
#endif`,C_=`#if NUM_SPOT_LIGHT_COORDS > 0
	uniform mat4 spotLightMatrix[ NUM_SPOT_LIGHT_COORDS ];
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		uniform mat4 directionalShadowMatrix[ NUM_DIR_LIGHT_SHADOWS ];
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		uniform mat4 pointShadowMatrix[ NUM_POINT_LIGHT_SHADOWS ];
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
#endif`,R_=`#if ( defined( USE_SHADOWMAP ) && ( NUM_DIR_LIGHT_SHADOWS > 0 || NUM_SUN_LIGHT_SHADOWS > 0 || NUM_POINT_LIGHT_SHADOWS > 0 ) ) || ( NUM_SPOT_LIGHT_COORDS > 0 )
	#ifdef HAS_NORMAL
		vec3 shadowWorldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
	#else
		vec3 shadowWorldNormal = vec3( 0.0 );
	#endif
	vec4 shadowWorldPosition;
#endif
#if defined( USE_SHADOWMAP )
	#if NUM_SUN_LIGHT_SHADOWS > 0
		vSunShadowWorldPosition = vec4( worldPosition.xyz, - mvPosition.z );
		vSunShadowWorldNormal = shadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * directionalLightShadows[ i ].shadowNormalBias, 0 );
			vDirectionalShadowCoord[ i ] = directionalShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * pointLightShadows[ i ].shadowNormalBias, 0 );
			vPointShadowCoord[ i ] = pointShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
#endif
#if NUM_SPOT_LIGHT_COORDS > 0
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_COORDS; i ++ ) {
		shadowWorldPosition = worldPosition;
		#if ( defined( USE_SHADOWMAP ) && UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
			shadowWorldPosition.xyz += shadowWorldNormal * spotLightShadows[ i ].shadowNormalBias;
		#endif
		vSpotLightCoord[ i ] = spotLightMatrix[ i ] * shadowWorldPosition;
	}
	#pragma unroll_loop_end
#endif`,P_=`float getShadowMask() {
	float shadow = 1.0;
	#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHT_SHADOWS; i ++ ) {
		sunLight = sunLightShadows[ i ];
		shadow *= receiveShadow ? getSunShadow( sunShadowMap[ i ], sunLight, UNROLLED_LOOP_INDEX ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
		directionalLight = directionalLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( directionalShadowMap[ i ], directionalLight.shadowMapSize, directionalLight.shadowIntensity, directionalLight.shadowBias, directionalLight.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_SHADOWS; i ++ ) {
		spotLight = spotLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( spotShadowMap[ i ], spotLight.shadowMapSize, spotLight.shadowIntensity, spotLight.shadowBias, spotLight.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0 && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
	PointLightShadow pointLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
		pointLight = pointLightShadows[ i ];
		shadow *= receiveShadow ? getPointShadow( pointShadowMap[ i ], pointLight.shadowMapSize, pointLight.shadowIntensity, pointLight.shadowBias, pointLight.shadowRadius, vPointShadowCoord[ i ], pointLight.shadowCameraNear, pointLight.shadowCameraFar ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#endif
	return shadow;
}`,I_=`#ifdef USE_SKINNING
	mat4 boneMatX = getBoneMatrix( skinIndex.x );
	mat4 boneMatY = getBoneMatrix( skinIndex.y );
	mat4 boneMatZ = getBoneMatrix( skinIndex.z );
	mat4 boneMatW = getBoneMatrix( skinIndex.w );
#endif`,L_=`#ifdef USE_SKINNING
	uniform mat4 bindMatrix;
	uniform mat4 bindMatrixInverse;
	uniform highp sampler2D boneTexture;
	mat4 getBoneMatrix( const in float i ) {
		int size = textureSize( boneTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( boneTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( boneTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( boneTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( boneTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
#endif`,D_=`#ifdef USE_SKINNING
	vec4 skinVertex = bindMatrix * vec4( transformed, 1.0 );
	vec4 skinned = vec4( 0.0 );
	skinned += boneMatX * skinVertex * skinWeight.x;
	skinned += boneMatY * skinVertex * skinWeight.y;
	skinned += boneMatZ * skinVertex * skinWeight.z;
	skinned += boneMatW * skinVertex * skinWeight.w;
	transformed = ( bindMatrixInverse * skinned ).xyz;
#endif`,N_=`#ifdef USE_SKINNING
	mat4 skinMatrix = mat4( 0.0 );
	skinMatrix += skinWeight.x * boneMatX;
	skinMatrix += skinWeight.y * boneMatY;
	skinMatrix += skinWeight.z * boneMatZ;
	skinMatrix += skinWeight.w * boneMatW;
	skinMatrix = bindMatrixInverse * skinMatrix * bindMatrix;
	objectNormal = vec4( skinMatrix * vec4( objectNormal, 0.0 ) ).xyz;
	#ifdef USE_TANGENT
		objectTangent = vec4( skinMatrix * vec4( objectTangent, 0.0 ) ).xyz;
	#endif
#endif`,U_=`float specularStrength;
#ifdef USE_SPECULARMAP
	vec4 texelSpecular = texture2D( specularMap, vSpecularMapUv );
	specularStrength = texelSpecular.r;
#else
	specularStrength = 1.0;
#endif`,F_=`#ifdef USE_SPECULARMAP
	uniform sampler2D specularMap;
#endif`,O_=`#if defined( TONE_MAPPING )
	gl_FragColor.rgb = toneMapping( gl_FragColor.rgb );
#endif`,B_=`#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
uniform float toneMappingExposure;
vec3 LinearToneMapping( vec3 color ) {
	return saturate( toneMappingExposure * color );
}
vec3 ReinhardToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	return saturate( color / ( vec3( 1.0 ) + color ) );
}
vec3 CineonToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	color = max( vec3( 0.0 ), color - 0.004 );
	return pow( ( color * ( 6.2 * color + 0.5 ) ) / ( color * ( 6.2 * color + 1.7 ) + 0.06 ), vec3( 2.2 ) );
}
vec3 RRTAndODTFit( vec3 v ) {
	vec3 a = v * ( v + 0.0245786 ) - 0.000090537;
	vec3 b = v * ( 0.983729 * v + 0.4329510 ) + 0.238081;
	return a / b;
}
vec3 ACESFilmicToneMapping( vec3 color ) {
	const mat3 ACESInputMat = mat3(
		vec3( 0.59719, 0.07600, 0.02840 ),		vec3( 0.35458, 0.90834, 0.13383 ),
		vec3( 0.04823, 0.01566, 0.83777 )
	);
	const mat3 ACESOutputMat = mat3(
		vec3(  1.60475, -0.10208, -0.00327 ),		vec3( -0.53108,  1.10813, -0.07276 ),
		vec3( -0.07367, -0.00605,  1.07602 )
	);
	color *= toneMappingExposure / 0.6;
	color = ACESInputMat * color;
	color = RRTAndODTFit( color );
	color = ACESOutputMat * color;
	return saturate( color );
}
const mat3 LINEAR_REC2020_TO_LINEAR_SRGB = mat3(
	vec3( 1.6605, - 0.1246, - 0.0182 ),
	vec3( - 0.5876, 1.1329, - 0.1006 ),
	vec3( - 0.0728, - 0.0083, 1.1187 )
);
const mat3 LINEAR_SRGB_TO_LINEAR_REC2020 = mat3(
	vec3( 0.6274, 0.0691, 0.0164 ),
	vec3( 0.3293, 0.9195, 0.0880 ),
	vec3( 0.0433, 0.0113, 0.8956 )
);
vec3 agxDefaultContrastApprox( vec3 x ) {
	vec3 x2 = x * x;
	vec3 x4 = x2 * x2;
	return + 15.5 * x4 * x2
		- 40.14 * x4 * x
		+ 31.96 * x4
		- 6.868 * x2 * x
		+ 0.4298 * x2
		+ 0.1191 * x
		- 0.00232;
}
vec3 AgXToneMapping( vec3 color ) {
	const mat3 AgXInsetMatrix = mat3(
		vec3( 0.856627153315983, 0.137318972929847, 0.11189821299995 ),
		vec3( 0.0951212405381588, 0.761241990602591, 0.0767994186031903 ),
		vec3( 0.0482516061458583, 0.101439036467562, 0.811302368396859 )
	);
	const mat3 AgXOutsetMatrix = mat3(
		vec3( 1.1271005818144368, - 0.1413297634984383, - 0.14132976349843826 ),
		vec3( - 0.11060664309660323, 1.157823702216272, - 0.11060664309660294 ),
		vec3( - 0.016493938717834573, - 0.016493938717834257, 1.2519364065950405 )
	);
	const float AgxMinEv = - 12.47393;	const float AgxMaxEv = 4.026069;
	color *= toneMappingExposure;
	color = LINEAR_SRGB_TO_LINEAR_REC2020 * color;
	color = AgXInsetMatrix * color;
	color = max( color, 1e-10 );	color = log2( color );
	color = ( color - AgxMinEv ) / ( AgxMaxEv - AgxMinEv );
	color = clamp( color, 0.0, 1.0 );
	color = agxDefaultContrastApprox( color );
	color = AgXOutsetMatrix * color;
	color = pow( max( vec3( 0.0 ), color ), vec3( 2.2 ) );
	color = LINEAR_REC2020_TO_LINEAR_SRGB * color;
	color = clamp( color, 0.0, 1.0 );
	return color;
}
vec3 NeutralToneMapping( vec3 color ) {
	const float StartCompression = 0.8 - 0.04;
	const float Desaturation = 0.15;
	color *= toneMappingExposure;
	float x = min( color.r, min( color.g, color.b ) );
	float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
	color -= offset;
	float peak = max( color.r, max( color.g, color.b ) );
	if ( peak < StartCompression ) return color;
	float d = 1. - StartCompression;
	float newPeak = 1. - d * d / ( peak + d - StartCompression );
	color *= newPeak / peak;
	float g = 1. - 1. / ( Desaturation * ( peak - newPeak ) + 1. );
	return mix( color, vec3( newPeak ), g );
}
vec3 CustomToneMapping( vec3 color ) { return color; }`,k_=`#ifdef USE_TRANSMISSION
	material.transmission = transmission;
	material.transmissionAlpha = 1.0;
	material.thickness = thickness;
	material.attenuationDistance = attenuationDistance;
	material.attenuationColor = attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		material.transmission *= texture2D( transmissionMap, vTransmissionMapUv ).r;
	#endif
	#ifdef USE_THICKNESSMAP
		material.thickness *= texture2D( thicknessMap, vThicknessMapUv ).g;
	#endif
	vec3 pos = vWorldPosition;
	vec3 v = normalize( cameraPosition - pos );
	vec3 n = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec4 transmitted = getIBLVolumeRefraction(
		n, v, material.roughness, material.diffuseContribution, material.specularColorBlended, material.specularF90,
		pos, modelMatrix, viewMatrix, projectionMatrix, material.dispersion, material.ior, material.thickness,
		material.attenuationColor, material.attenuationDistance );
	material.transmissionAlpha = mix( material.transmissionAlpha, transmitted.a, material.transmission );
	totalDiffuse = mix( totalDiffuse, transmitted.rgb, material.transmission );
#endif`,z_=`#ifdef USE_TRANSMISSION
	uniform float transmission;
	uniform float thickness;
	uniform float attenuationDistance;
	uniform vec3 attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		uniform sampler2D transmissionMap;
	#endif
	#ifdef USE_THICKNESSMAP
		uniform sampler2D thicknessMap;
	#endif
	uniform vec2 transmissionSamplerSize;
	uniform sampler2D transmissionSamplerMap;
	uniform mat4 modelMatrix;
	uniform mat4 projectionMatrix;
	varying vec3 vWorldPosition;
	float w0( float a ) {
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - a + 3.0 ) - 3.0 ) + 1.0 );
	}
	float w1( float a ) {
		return ( 1.0 / 6.0 ) * ( a *  a * ( 3.0 * a - 6.0 ) + 4.0 );
	}
	float w2( float a ){
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - 3.0 * a + 3.0 ) + 3.0 ) + 1.0 );
	}
	float w3( float a ) {
		return ( 1.0 / 6.0 ) * ( a * a * a );
	}
	float g0( float a ) {
		return w0( a ) + w1( a );
	}
	float g1( float a ) {
		return w2( a ) + w3( a );
	}
	float h0( float a ) {
		return - 1.0 + w1( a ) / ( w0( a ) + w1( a ) );
	}
	float h1( float a ) {
		return 1.0 + w3( a ) / ( w2( a ) + w3( a ) );
	}
	vec4 bicubic( sampler2D tex, vec2 uv, vec4 texelSize, float lod ) {
		uv = uv * texelSize.zw + 0.5;
		vec2 iuv = floor( uv );
		vec2 fuv = fract( uv );
		float g0x = g0( fuv.x );
		float g1x = g1( fuv.x );
		float h0x = h0( fuv.x );
		float h1x = h1( fuv.x );
		float h0y = h0( fuv.y );
		float h1y = h1( fuv.y );
		vec2 p0 = ( vec2( iuv.x + h0x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p1 = ( vec2( iuv.x + h1x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p2 = ( vec2( iuv.x + h0x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		vec2 p3 = ( vec2( iuv.x + h1x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		return g0( fuv.y ) * ( g0x * textureLod( tex, p0, lod ) + g1x * textureLod( tex, p1, lod ) ) +
			g1( fuv.y ) * ( g0x * textureLod( tex, p2, lod ) + g1x * textureLod( tex, p3, lod ) );
	}
	vec4 textureBicubic( sampler2D sampler, vec2 uv, float lod ) {
		vec2 fLodSize = vec2( textureSize( sampler, int( lod ) ) );
		vec2 cLodSize = vec2( textureSize( sampler, int( lod + 1.0 ) ) );
		vec2 fLodSizeInv = 1.0 / fLodSize;
		vec2 cLodSizeInv = 1.0 / cLodSize;
		vec4 fSample = bicubic( sampler, uv, vec4( fLodSizeInv, fLodSize ), floor( lod ) );
		vec4 cSample = bicubic( sampler, uv, vec4( cLodSizeInv, cLodSize ), ceil( lod ) );
		return mix( fSample, cSample, fract( lod ) );
	}
	vec3 getVolumeTransmissionRay( const in vec3 n, const in vec3 v, const in float thickness, const in float ior, const in mat4 modelMatrix ) {
		vec3 refractionVector = refract( - v, normalize( n ), 1.0 / ior );
		vec3 modelScale;
		modelScale.x = length( vec3( modelMatrix[ 0 ].xyz ) );
		modelScale.y = length( vec3( modelMatrix[ 1 ].xyz ) );
		modelScale.z = length( vec3( modelMatrix[ 2 ].xyz ) );
		return normalize( refractionVector ) * thickness * modelScale;
	}
	float applyIorToRoughness( const in float roughness, const in float ior ) {
		return roughness * clamp( ior * 2.0 - 2.0, 0.0, 1.0 );
	}
	vec4 getTransmissionSample( const in vec2 fragCoord, const in float roughness, const in float ior ) {
		float lod = log2( transmissionSamplerSize.x ) * applyIorToRoughness( roughness, ior );
		return textureBicubic( transmissionSamplerMap, fragCoord.xy, lod );
	}
	vec3 volumeAttenuation( const in float transmissionDistance, const in vec3 attenuationColor, const in float attenuationDistance ) {
		if ( isinf( attenuationDistance ) ) {
			return vec3( 1.0 );
		} else {
			vec3 attenuationCoefficient = -log( attenuationColor ) / attenuationDistance;
			vec3 transmittance = exp( - attenuationCoefficient * transmissionDistance );			return transmittance;
		}
	}
	vec4 getIBLVolumeRefraction( const in vec3 n, const in vec3 v, const in float roughness, const in vec3 diffuseColor,
		const in vec3 specularColor, const in float specularF90, const in vec3 position, const in mat4 modelMatrix,
		const in mat4 viewMatrix, const in mat4 projMatrix, const in float dispersion, const in float ior, const in float thickness,
		const in vec3 attenuationColor, const in float attenuationDistance ) {
		vec4 transmittedLight;
		vec3 transmittance;
		#ifdef USE_DISPERSION
			float halfSpread = ( ior - 1.0 ) * 0.025 * dispersion;
			vec3 iors = vec3( ior - halfSpread, ior, ior + halfSpread );
			for ( int i = 0; i < 3; i ++ ) {
				vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, iors[ i ], modelMatrix );
				vec3 refractedRayExit = position + transmissionRay;
				vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
				vec2 refractionCoords = ndcPos.xy / ndcPos.w;
				refractionCoords += 1.0;
				refractionCoords /= 2.0;
				vec4 transmissionSample = getTransmissionSample( refractionCoords, roughness, iors[ i ] );
				transmittedLight[ i ] = transmissionSample[ i ];
				transmittedLight.a += transmissionSample.a;
				transmittance[ i ] = diffuseColor[ i ] * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance )[ i ];
			}
			transmittedLight.a /= 3.0;
		#else
			vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, ior, modelMatrix );
			vec3 refractedRayExit = position + transmissionRay;
			vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
			vec2 refractionCoords = ndcPos.xy / ndcPos.w;
			refractionCoords += 1.0;
			refractionCoords /= 2.0;
			transmittedLight = getTransmissionSample( refractionCoords, roughness, ior );
			transmittance = diffuseColor * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance );
		#endif
		vec3 attenuatedColor = transmittance * transmittedLight.rgb;
		vec3 F = EnvironmentBRDF( n, v, specularColor, specularF90, roughness );
		float transmittanceFactor = ( transmittance.r + transmittance.g + transmittance.b ) / 3.0;
		return vec4( ( 1.0 - F ) * attenuatedColor, 1.0 - ( 1.0 - transmittedLight.a ) * transmittanceFactor );
	}
#endif`,H_=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_SPECULARMAP
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,G_=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	uniform mat3 mapTransform;
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	uniform mat3 alphaMapTransform;
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	uniform mat3 lightMapTransform;
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	uniform mat3 aoMapTransform;
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	uniform mat3 bumpMapTransform;
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	uniform mat3 normalMapTransform;
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_DISPLACEMENTMAP
	uniform mat3 displacementMapTransform;
	varying vec2 vDisplacementMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	uniform mat3 emissiveMapTransform;
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	uniform mat3 metalnessMapTransform;
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	uniform mat3 roughnessMapTransform;
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	uniform mat3 diffuseRoughnessMapTransform;
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	uniform mat3 anisotropyMapTransform;
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	uniform mat3 clearcoatMapTransform;
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform mat3 clearcoatNormalMapTransform;
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform mat3 clearcoatRoughnessMapTransform;
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	uniform mat3 sheenColorMapTransform;
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	uniform mat3 sheenRoughnessMapTransform;
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	uniform mat3 iridescenceMapTransform;
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform mat3 iridescenceThicknessMapTransform;
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SPECULARMAP
	uniform mat3 specularMapTransform;
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	uniform mat3 specularColorMapTransform;
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	uniform mat3 specularIntensityMapTransform;
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,V_=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	vUv = vec3( uv, 1 ).xy;
#endif
#ifdef USE_MAP
	vMapUv = ( mapTransform * vec3( MAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ALPHAMAP
	vAlphaMapUv = ( alphaMapTransform * vec3( ALPHAMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_LIGHTMAP
	vLightMapUv = ( lightMapTransform * vec3( LIGHTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_AOMAP
	vAoMapUv = ( aoMapTransform * vec3( AOMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_BUMPMAP
	vBumpMapUv = ( bumpMapTransform * vec3( BUMPMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_NORMALMAP
	vNormalMapUv = ( normalMapTransform * vec3( NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DISPLACEMENTMAP
	vDisplacementMapUv = ( displacementMapTransform * vec3( DISPLACEMENTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_EMISSIVEMAP
	vEmissiveMapUv = ( emissiveMapTransform * vec3( EMISSIVEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_METALNESSMAP
	vMetalnessMapUv = ( metalnessMapTransform * vec3( METALNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ROUGHNESSMAP
	vRoughnessMapUv = ( roughnessMapTransform * vec3( ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	vDiffuseRoughnessMapUv = ( diffuseRoughnessMapTransform * vec3( DIFFUSE_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ANISOTROPYMAP
	vAnisotropyMapUv = ( anisotropyMapTransform * vec3( ANISOTROPYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOATMAP
	vClearcoatMapUv = ( clearcoatMapTransform * vec3( CLEARCOATMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	vClearcoatNormalMapUv = ( clearcoatNormalMapTransform * vec3( CLEARCOAT_NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	vClearcoatRoughnessMapUv = ( clearcoatRoughnessMapTransform * vec3( CLEARCOAT_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCEMAP
	vIridescenceMapUv = ( iridescenceMapTransform * vec3( IRIDESCENCEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	vIridescenceThicknessMapUv = ( iridescenceThicknessMapTransform * vec3( IRIDESCENCE_THICKNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_COLORMAP
	vSheenColorMapUv = ( sheenColorMapTransform * vec3( SHEEN_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	vSheenRoughnessMapUv = ( sheenRoughnessMapTransform * vec3( SHEEN_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULARMAP
	vSpecularMapUv = ( specularMapTransform * vec3( SPECULARMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_COLORMAP
	vSpecularColorMapUv = ( specularColorMapTransform * vec3( SPECULAR_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	vSpecularIntensityMapUv = ( specularIntensityMapTransform * vec3( SPECULAR_INTENSITYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_TRANSMISSIONMAP
	vTransmissionMapUv = ( transmissionMapTransform * vec3( TRANSMISSIONMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_THICKNESSMAP
	vThicknessMapUv = ( thicknessMapTransform * vec3( THICKNESSMAP_UV, 1 ) ).xy;
#endif`,W_=`#if defined( USE_ENVMAP ) || defined( DISTANCE ) || defined ( USE_SHADOWMAP ) || defined ( USE_TRANSMISSION ) || NUM_SPOT_LIGHT_COORDS > 0
	vec4 worldPosition = vec4( transformed, 1.0 );
	#ifdef USE_BATCHING
		worldPosition = batchingMatrix * worldPosition;
	#endif
	#ifdef USE_INSTANCING
		worldPosition = instanceMatrix * worldPosition;
	#endif
	worldPosition = modelMatrix * worldPosition;
#endif`,$_=`varying vec2 vUv;
uniform mat3 uvTransform;
void main() {
	vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	gl_Position = vec4( position.xy, 1.0, 1.0 );
}`,X_=`uniform sampler2D t2D;
uniform float backgroundIntensity;
varying vec2 vUv;
void main() {
	vec4 texColor = texture2D( t2D, vUv );
	#ifdef DECODE_VIDEO_TEXTURE
		texColor = vec4( mix( pow( texColor.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), texColor.rgb * 0.0773993808, vec3( lessThanEqual( texColor.rgb, vec3( 0.04045 ) ) ) ), texColor.w );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,q_=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,Y_=`uniform float backgroundBlurriness;
uniform float backgroundIntensity;
uniform mat3 backgroundRotation;
varying vec3 vWorldDirection;
#include <envmap_common_pars_fragment>
void main() {
	#ifdef ENVMAP_TYPE_PMREM
		vec4 texColor = textureLod( envMap, backgroundRotation * vWorldDirection, roughnessToMip( backgroundBlurriness ) );
	#else
		vec4 texColor = textureCube( envMap, backgroundRotation * vWorldDirection );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,j_=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,Z_=`uniform samplerCube tCube;
uniform float tFlip;
uniform float opacity;
varying vec3 vWorldDirection;
void main() {
	vec4 texColor = textureCube( tCube, vec3( tFlip * vWorldDirection.x, vWorldDirection.yz ) );
	gl_FragColor = texColor;
	gl_FragColor.a *= opacity;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,K_=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
varying vec2 vHighPrecisionZW;
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vHighPrecisionZW = gl_Position.zw;
}`,J_=`#if DEPTH_PACKING == 3200
	uniform float opacity;
#endif
#include <common>
#include <packing>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
varying vec2 vHighPrecisionZW;
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#if DEPTH_PACKING == 3200
		diffuseColor.a = opacity;
	#endif
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <logdepthbuf_fragment>
	#ifdef USE_REVERSED_DEPTH_BUFFER
		float fragCoordZ = vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ];
	#else
		float fragCoordZ = 0.5 * vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ] + 0.5;
	#endif
	#if DEPTH_PACKING == 3200
		gl_FragColor = vec4( vec3( 1.0 - fragCoordZ ), opacity );
	#elif DEPTH_PACKING == 3201
		gl_FragColor = packDepthToRGBA( fragCoordZ );
	#elif DEPTH_PACKING == 3202
		gl_FragColor = vec4( packDepthToRGB( fragCoordZ ), 1.0 );
	#elif DEPTH_PACKING == 3203
		gl_FragColor = vec4( packDepthToRG( fragCoordZ ), 0.0, 1.0 );
	#endif
}`,Q_=`#define DISTANCE
varying vec3 vWorldPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <worldpos_vertex>
	#include <clipping_planes_vertex>
	vWorldPosition = worldPosition.xyz;
}`,ty=`#define DISTANCE
uniform vec3 referencePosition;
uniform float nearDistance;
uniform float farDistance;
varying vec3 vWorldPosition;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	float dist = length( vWorldPosition - referencePosition );
	dist = ( dist - nearDistance ) / ( farDistance - nearDistance );
	dist = saturate( dist );
	gl_FragColor = vec4( dist, 0.0, 0.0, 1.0 );
}`,ey=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
}`,ny=`uniform sampler2D tEquirect;
varying vec3 vWorldDirection;
#include <common>
void main() {
	vec3 direction = normalize( vWorldDirection );
	vec2 sampleUV = equirectUv( direction );
	gl_FragColor = texture2D( tEquirect, sampleUV );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,iy=`uniform float scale;
attribute float lineDistance;
varying float vLineDistance;
#include <common>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	vLineDistance = scale * lineDistance;
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,sy=`uniform vec3 diffuse;
uniform float opacity;
uniform float dashSize;
uniform float totalSize;
varying float vLineDistance;
#include <common>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	if ( mod( vLineDistance, totalSize ) > dashSize ) {
		discard;
	}
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,ry=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#if defined ( USE_ENVMAP ) || defined ( USE_SKINNING )
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinbase_vertex>
		#include <skinnormal_vertex>
		#include <defaultnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <fog_vertex>
}`,oy=`uniform vec3 diffuse;
uniform float opacity;
#ifndef FLAT_SHADED
	varying vec3 vNormal;
#endif
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <fog_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		reflectedLight.indirectDiffuse += lightMapTexel.rgb * lightMapIntensity * RECIPROCAL_PI;
	#else
		reflectedLight.indirectDiffuse += vec3( 1.0 );
	#endif
	#include <aomap_fragment>
	reflectedLight.indirectDiffuse *= diffuseColor.rgb;
	vec3 outgoingLight = reflectedLight.indirectDiffuse;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,ay=`#define LAMBERT
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,ly=`#define LAMBERT
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_lambert_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_lambert_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,cy=`#define MATCAP
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <displacementmap_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
	vViewPosition = - mvPosition.xyz;
}`,hy=`#define MATCAP
uniform vec3 diffuse;
uniform float opacity;
uniform sampler2D matcap;
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	vec3 viewDir = normalize( vViewPosition );
	vec3 x = normalize( vec3( viewDir.z, 0.0, - viewDir.x ) );
	vec3 y = cross( viewDir, x );
	vec2 uv = vec2( dot( x, normal ), dot( y, normal ) ) * 0.495 + 0.5;
	#ifdef USE_MATCAP
		vec4 matcapColor = texture2D( matcap, uv );
	#else
		vec4 matcapColor = vec4( vec3( mix( 0.2, 0.8, uv.y ) ), 1.0 );
	#endif
	vec3 outgoingLight = diffuseColor.rgb * matcapColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,uy=`#define NORMAL
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	vViewPosition = - mvPosition.xyz;
#endif
}`,dy=`#define NORMAL
uniform float opacity;
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <uv_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 0.0, 0.0, 0.0, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	gl_FragColor = vec4( normalize( normal ) * 0.5 + 0.5, diffuseColor.a );
	#ifdef OPAQUE
		gl_FragColor.a = 1.0;
	#endif
}`,fy=`#define PHONG
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,py=`#define PHONG
uniform vec3 diffuse;
uniform vec3 emissive;
uniform vec3 specular;
uniform float shininess;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_phong_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_phong_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + reflectedLight.directSpecular + reflectedLight.indirectSpecular + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,my=`#define STANDARD
varying vec3 vViewPosition;
#ifdef USE_TRANSMISSION
	varying vec3 vWorldPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
#ifdef USE_TRANSMISSION
	vWorldPosition = worldPosition.xyz;
#endif
}`,gy=`#define STANDARD
#ifdef PHYSICAL
	#define IOR
	#define USE_SPECULAR
#endif
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float roughness;
uniform float metalness;
uniform float opacity;
#ifdef IOR
	uniform float ior;
#endif
#ifdef USE_SPECULAR
	uniform float specularIntensity;
	uniform vec3 specularColor;
	#ifdef USE_SPECULAR_COLORMAP
		uniform sampler2D specularColorMap;
	#endif
	#ifdef USE_SPECULAR_INTENSITYMAP
		uniform sampler2D specularIntensityMap;
	#endif
#endif
#ifdef USE_CLEARCOAT
	uniform float clearcoat;
	uniform float clearcoatRoughness;
#endif
#ifdef USE_DIFFUSE_ROUGHNESS
	uniform float diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		uniform sampler2D diffuseRoughnessMap;
	#endif
#endif
#ifdef USE_DISPERSION
	uniform float dispersion;
#endif
#ifdef USE_RETROREFLECTION
	uniform float retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	uniform float iridescence;
	uniform float iridescenceIOR;
	uniform float iridescenceThicknessMinimum;
	uniform float iridescenceThicknessMaximum;
#endif
#ifdef USE_SHEEN
	uniform vec3 sheenColor;
	uniform float sheenRoughness;
	#ifdef USE_SHEEN_COLORMAP
		uniform sampler2D sheenColorMap;
	#endif
	#ifdef USE_SHEEN_ROUGHNESSMAP
		uniform sampler2D sheenRoughnessMap;
	#endif
#endif
#ifdef USE_ANISOTROPY
	uniform vec2 anisotropyVector;
	#ifdef USE_ANISOTROPYMAP
		uniform sampler2D anisotropyMap;
	#endif
#endif
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <iridescence_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_physical_pars_fragment>
#include <transmission_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <clearcoat_pars_fragment>
#include <iridescence_pars_fragment>
#include <roughnessmap_pars_fragment>
#include <metalnessmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <roughnessmap_fragment>
	#include <metalnessmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <clearcoat_normal_fragment_begin>
	#include <clearcoat_normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_physical_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 totalDiffuse = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
	vec3 totalSpecular = reflectedLight.directSpecular + reflectedLight.indirectSpecular;
	#include <transmission_fragment>
	vec3 outgoingLight = totalDiffuse + totalSpecular + totalEmissiveRadiance;
	#ifdef USE_SHEEN
 
		outgoingLight = outgoingLight + sheenSpecularDirect + sheenSpecularIndirect;
 
 	#endif
	#ifdef USE_CLEARCOAT
		float dotNVcc = saturate( dot( geometryClearcoatNormal, geometryViewDir ) );
		vec3 Fcc = F_Schlick( material.clearcoatF0, material.clearcoatF90, dotNVcc );
		outgoingLight = outgoingLight * ( 1.0 - material.clearcoat * Fcc ) + ( clearcoatSpecularDirect + clearcoatSpecularIndirect ) * material.clearcoat;
	#endif
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,vy=`#define TOON
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,xy=`#define TOON
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <gradientmap_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_toon_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_toon_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,_y=`uniform float size;
uniform float scale;
#include <common>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
#ifdef USE_POINTS_UV
	varying vec2 vUv;
	uniform mat3 uvTransform;
#endif
void main() {
	#ifdef USE_POINTS_UV
		vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	#endif
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	gl_PointSize = size;
	#ifdef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) gl_PointSize *= ( scale / - mvPosition.z );
	#endif
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <fog_vertex>
}`,yy=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <color_pars_fragment>
#include <map_particle_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_particle_fragment>
	#include <color_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,by=`#include <common>
#include <batching_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <shadowmap_pars_vertex>
void main() {
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,Sy=`uniform vec3 color;
uniform float opacity;
#include <common>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <logdepthbuf_pars_fragment>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
void main() {
	#include <logdepthbuf_fragment>
	gl_FragColor = vec4( color, opacity * ( 1.0 - getShadowMask() ) );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,My=`uniform float rotation;
uniform vec2 center;
#include <common>
#include <uv_pars_vertex>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	vec4 mvPosition = modelViewMatrix[ 3 ];
	vec2 scale = vec2( length( modelMatrix[ 0 ].xyz ), length( modelMatrix[ 1 ].xyz ) );
	#ifndef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) scale *= - mvPosition.z;
	#endif
	vec2 alignedPosition = ( position.xy - ( center - vec2( 0.5 ) ) ) * scale;
	vec2 rotatedPosition;
	rotatedPosition.x = cos( rotation ) * alignedPosition.x - sin( rotation ) * alignedPosition.y;
	rotatedPosition.y = sin( rotation ) * alignedPosition.x + cos( rotation ) * alignedPosition.y;
	mvPosition.xy += rotatedPosition;
	gl_Position = projectionMatrix * mvPosition;
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,wy=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
}`,Ht={alphahash_fragment:Xv,alphahash_pars_fragment:qv,alphamap_fragment:Yv,alphamap_pars_fragment:jv,alphatest_fragment:Zv,alphatest_pars_fragment:Kv,aomap_fragment:Jv,aomap_pars_fragment:Qv,batching_pars_vertex:tx,batching_vertex:ex,begin_vertex:nx,beginnormal_vertex:ix,bsdfs:sx,iridescence_fragment:rx,bumpmap_pars_fragment:ox,clipping_planes_fragment:ax,clipping_planes_pars_fragment:lx,clipping_planes_pars_vertex:cx,clipping_planes_vertex:hx,color_fragment:ux,color_pars_fragment:dx,color_pars_vertex:fx,color_vertex:px,common:mx,defaultnormal_vertex:gx,displacementmap_pars_vertex:vx,displacementmap_vertex:xx,emissivemap_fragment:_x,emissivemap_pars_fragment:yx,colorspace_fragment:bx,colorspace_pars_fragment:Sx,envmap_fragment:Mx,envmap_common_pars_fragment:wx,envmap_pars_fragment:Ex,envmap_pars_vertex:Ax,envmap_physical_pars_fragment:Ox,envmap_vertex:Tx,fog_vertex:Cx,fog_pars_vertex:Rx,fog_fragment:Px,fog_pars_fragment:Ix,gradientmap_pars_fragment:Lx,lightmap_pars_fragment:Dx,lights_lambert_fragment:Nx,lights_lambert_pars_fragment:Ux,lights_pars_begin:Fx,lights_toon_fragment:Bx,lights_toon_pars_fragment:kx,lights_phong_fragment:zx,lights_phong_pars_fragment:Hx,lights_physical_fragment:Gx,lights_physical_pars_fragment:Vx,lights_fragment_begin:Wx,lights_fragment_maps:$x,lights_fragment_end:Xx,lightprobes_pars_fragment:qx,logdepthbuf_fragment:Yx,logdepthbuf_pars_fragment:jx,logdepthbuf_pars_vertex:Zx,logdepthbuf_vertex:Kx,map_fragment:Jx,map_pars_fragment:Qx,map_particle_fragment:t_,map_particle_pars_fragment:e_,metalnessmap_fragment:n_,metalnessmap_pars_fragment:i_,morphinstance_vertex:s_,morphcolor_vertex:r_,morphnormal_vertex:o_,morphtarget_pars_vertex:a_,morphtarget_vertex:l_,normal_fragment_begin:c_,normal_fragment_maps:h_,normal_pars_fragment:u_,normal_pars_vertex:d_,normal_vertex:f_,normalmap_pars_fragment:p_,clearcoat_normal_fragment_begin:m_,clearcoat_normal_fragment_maps:g_,clearcoat_pars_fragment:v_,iridescence_pars_fragment:x_,opaque_fragment:__,packing:y_,premultiplied_alpha_fragment:b_,project_vertex:S_,dithering_fragment:M_,dithering_pars_fragment:w_,roughnessmap_fragment:E_,roughnessmap_pars_fragment:A_,shadowmap_pars_fragment:T_,shadowmap_pars_vertex:C_,shadowmap_vertex:R_,shadowmask_pars_fragment:P_,skinbase_vertex:I_,skinning_pars_vertex:L_,skinning_vertex:D_,skinnormal_vertex:N_,specularmap_fragment:U_,specularmap_pars_fragment:F_,tonemapping_fragment:O_,tonemapping_pars_fragment:B_,transmission_fragment:k_,transmission_pars_fragment:z_,uv_pars_fragment:H_,uv_pars_vertex:G_,uv_vertex:V_,worldpos_vertex:W_,background_vert:$_,background_frag:X_,backgroundCube_vert:q_,backgroundCube_frag:Y_,cube_vert:j_,cube_frag:Z_,depth_vert:K_,depth_frag:J_,distance_vert:Q_,distance_frag:ty,equirect_vert:ey,equirect_frag:ny,linedashed_vert:iy,linedashed_frag:sy,meshbasic_vert:ry,meshbasic_frag:oy,meshlambert_vert:ay,meshlambert_frag:ly,meshmatcap_vert:cy,meshmatcap_frag:hy,meshnormal_vert:uy,meshnormal_frag:dy,meshphong_vert:fy,meshphong_frag:py,meshphysical_vert:my,meshphysical_frag:gy,meshtoon_vert:vy,meshtoon_frag:xy,points_vert:_y,points_frag:yy,shadow_vert:by,shadow_frag:Sy,sprite_vert:My,sprite_frag:wy},ft={common:{diffuse:{value:new Gt(16777215)},opacity:{value:1},map:{value:null},mapTransform:{value:new Nt},alphaMap:{value:null},alphaMapTransform:{value:new Nt},alphaTest:{value:0}},specularmap:{specularMap:{value:null},specularMapTransform:{value:new Nt}},envmap:{envMap:{value:null},envMapRotation:{value:new Nt},reflectivity:{value:1},ior:{value:1.5},refractionRatio:{value:.98},dfgLUT:{value:null}},aomap:{aoMap:{value:null},aoMapIntensity:{value:1},aoMapTransform:{value:new Nt}},lightmap:{lightMap:{value:null},lightMapIntensity:{value:1},lightMapTransform:{value:new Nt}},bumpmap:{bumpMap:{value:null},bumpMapTransform:{value:new Nt},bumpScale:{value:1}},normalmap:{normalMap:{value:null},normalMapTransform:{value:new Nt},normalScale:{value:new Ct(1,1)}},displacementmap:{displacementMap:{value:null},displacementMapTransform:{value:new Nt},displacementScale:{value:1},displacementBias:{value:0}},emissivemap:{emissiveMap:{value:null},emissiveMapTransform:{value:new Nt}},metalnessmap:{metalnessMap:{value:null},metalnessMapTransform:{value:new Nt}},roughnessmap:{roughnessMap:{value:null},roughnessMapTransform:{value:new Nt}},gradientmap:{gradientMap:{value:null}},fog:{fogDensity:{value:25e-5},fogNear:{value:1},fogFar:{value:2e3},fogColor:{value:new Gt(16777215)}},lights:{ambientLightColor:{value:[]},lightProbe:{value:[]},sunLights:{value:[],properties:{direction:{},color:{}}},sunLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},sunShadowMatrix:{value:[]},sunShadowCascade:{value:[]},directionalLights:{value:[],properties:{direction:{},color:{}}},directionalLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},directionalShadowMatrix:{value:[]},spotLights:{value:[],properties:{color:{},position:{},direction:{},distance:{},coneCos:{},penumbraCos:{},decay:{}}},spotLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},spotLightMap:{value:[]},spotLightMatrix:{value:[]},pointLights:{value:[],properties:{color:{},position:{},decay:{},distance:{}}},pointLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{},shadowCameraNear:{},shadowCameraFar:{}}},pointShadowMatrix:{value:[]},hemisphereLights:{value:[],properties:{direction:{},skyColor:{},groundColor:{}}},rectAreaLights:{value:[],properties:{color:{},position:{},width:{},height:{}}},ltc_1:{value:null},ltc_2:{value:null},probesSH:{value:[]},probesMin:{value:[]},probesMax:{value:[]},probesResolution:{value:[]}},points:{diffuse:{value:new Gt(16777215)},opacity:{value:1},size:{value:1},scale:{value:1},map:{value:null},alphaMap:{value:null},alphaMapTransform:{value:new Nt},alphaTest:{value:0},uvTransform:{value:new Nt}},sprite:{diffuse:{value:new Gt(16777215)},opacity:{value:1},center:{value:new Ct(.5,.5)},rotation:{value:0},map:{value:null},mapTransform:{value:new Nt},alphaMap:{value:null},alphaMapTransform:{value:new Nt},alphaTest:{value:0}}},nn={basic:{uniforms:Ye([ft.common,ft.specularmap,ft.envmap,ft.aomap,ft.lightmap,ft.fog]),vertexShader:Ht.meshbasic_vert,fragmentShader:Ht.meshbasic_frag},lambert:{uniforms:Ye([ft.common,ft.specularmap,ft.envmap,ft.aomap,ft.lightmap,ft.emissivemap,ft.bumpmap,ft.normalmap,ft.displacementmap,ft.fog,ft.lights,{emissive:{value:new Gt(0)},envMapIntensity:{value:1}}]),vertexShader:Ht.meshlambert_vert,fragmentShader:Ht.meshlambert_frag},phong:{uniforms:Ye([ft.common,ft.specularmap,ft.envmap,ft.aomap,ft.lightmap,ft.emissivemap,ft.bumpmap,ft.normalmap,ft.displacementmap,ft.fog,ft.lights,{emissive:{value:new Gt(0)},specular:{value:new Gt(1118481)},shininess:{value:30},envMapIntensity:{value:1}}]),vertexShader:Ht.meshphong_vert,fragmentShader:Ht.meshphong_frag},standard:{uniforms:Ye([ft.common,ft.envmap,ft.aomap,ft.lightmap,ft.emissivemap,ft.bumpmap,ft.normalmap,ft.displacementmap,ft.roughnessmap,ft.metalnessmap,ft.fog,ft.lights,{emissive:{value:new Gt(0)},roughness:{value:1},metalness:{value:0},envMapIntensity:{value:1}}]),vertexShader:Ht.meshphysical_vert,fragmentShader:Ht.meshphysical_frag},toon:{uniforms:Ye([ft.common,ft.aomap,ft.lightmap,ft.emissivemap,ft.bumpmap,ft.normalmap,ft.displacementmap,ft.gradientmap,ft.fog,ft.lights,{emissive:{value:new Gt(0)}}]),vertexShader:Ht.meshtoon_vert,fragmentShader:Ht.meshtoon_frag},matcap:{uniforms:Ye([ft.common,ft.bumpmap,ft.normalmap,ft.displacementmap,ft.fog,{matcap:{value:null}}]),vertexShader:Ht.meshmatcap_vert,fragmentShader:Ht.meshmatcap_frag},points:{uniforms:Ye([ft.points,ft.fog]),vertexShader:Ht.points_vert,fragmentShader:Ht.points_frag},dashed:{uniforms:Ye([ft.common,ft.fog,{scale:{value:1},dashSize:{value:1},totalSize:{value:2}}]),vertexShader:Ht.linedashed_vert,fragmentShader:Ht.linedashed_frag},depth:{uniforms:Ye([ft.common,ft.displacementmap]),vertexShader:Ht.depth_vert,fragmentShader:Ht.depth_frag},normal:{uniforms:Ye([ft.common,ft.bumpmap,ft.normalmap,ft.displacementmap,{opacity:{value:1}}]),vertexShader:Ht.meshnormal_vert,fragmentShader:Ht.meshnormal_frag},sprite:{uniforms:Ye([ft.sprite,ft.fog]),vertexShader:Ht.sprite_vert,fragmentShader:Ht.sprite_frag},background:{uniforms:{uvTransform:{value:new Nt},t2D:{value:null},backgroundIntensity:{value:1}},vertexShader:Ht.background_vert,fragmentShader:Ht.background_frag},backgroundCube:{uniforms:{envMap:{value:null},backgroundBlurriness:{value:0},backgroundIntensity:{value:1},backgroundRotation:{value:new Nt}},vertexShader:Ht.backgroundCube_vert,fragmentShader:Ht.backgroundCube_frag},cube:{uniforms:{tCube:{value:null},tFlip:{value:-1},opacity:{value:1}},vertexShader:Ht.cube_vert,fragmentShader:Ht.cube_frag},equirect:{uniforms:{tEquirect:{value:null}},vertexShader:Ht.equirect_vert,fragmentShader:Ht.equirect_frag},distance:{uniforms:Ye([ft.common,ft.displacementmap,{referencePosition:{value:new P},nearDistance:{value:1},farDistance:{value:1e3}}]),vertexShader:Ht.distance_vert,fragmentShader:Ht.distance_frag},shadow:{uniforms:Ye([ft.lights,ft.fog,{color:{value:new Gt(0)},opacity:{value:1}}]),vertexShader:Ht.shadow_vert,fragmentShader:Ht.shadow_frag}};nn.physical={uniforms:Ye([nn.standard.uniforms,{clearcoat:{value:0},clearcoatMap:{value:null},clearcoatMapTransform:{value:new Nt},clearcoatNormalMap:{value:null},clearcoatNormalMapTransform:{value:new Nt},clearcoatNormalScale:{value:new Ct(1,1)},clearcoatRoughness:{value:0},clearcoatRoughnessMap:{value:null},clearcoatRoughnessMapTransform:{value:new Nt},diffuseRoughness:{value:0},diffuseRoughnessMap:{value:null},diffuseRoughnessMapTransform:{value:new Nt},dispersion:{value:0},retroreflectivity:{value:0},iridescence:{value:0},iridescenceMap:{value:null},iridescenceMapTransform:{value:new Nt},iridescenceIOR:{value:1.3},iridescenceThicknessMinimum:{value:100},iridescenceThicknessMaximum:{value:400},iridescenceThicknessMap:{value:null},iridescenceThicknessMapTransform:{value:new Nt},sheen:{value:0},sheenColor:{value:new Gt(0)},sheenColorMap:{value:null},sheenColorMapTransform:{value:new Nt},sheenRoughness:{value:1},sheenRoughnessMap:{value:null},sheenRoughnessMapTransform:{value:new Nt},transmission:{value:0},transmissionMap:{value:null},transmissionMapTransform:{value:new Nt},transmissionSamplerSize:{value:new Ct},transmissionSamplerMap:{value:null},thickness:{value:0},thicknessMap:{value:null},thicknessMapTransform:{value:new Nt},attenuationDistance:{value:0},attenuationColor:{value:new Gt(0)},specularColor:{value:new Gt(1,1,1)},specularColorMap:{value:null},specularColorMapTransform:{value:new Nt},specularIntensity:{value:1},specularIntensityMap:{value:null},specularIntensityMapTransform:{value:new Nt},anisotropyVector:{value:new Ct},anisotropyMap:{value:null},anisotropyMapTransform:{value:new Nt}}]),vertexShader:Ht.meshphysical_vert,fragmentShader:Ht.meshphysical_frag};var _l={r:0,b:0,g:0},Ey=new jt,Pp=new Nt;Pp.set(-1,0,0,0,1,0,0,0,1);function Ay(i,t,e,n,s,r){let o=new Gt(0),a=s===!0?0:1,l,c,h=null,d=0,u=null;function f(_){let M=_.isScene===!0?_.background:null;if(M&&M.isTexture){let y=_.backgroundBlurriness>0;M=t.get(M,y)}return M}function g(_){let M=!1,y=f(_);y===null?p(o,a):y&&y.isColor&&(p(y,1),M=!0);let T=i.xr.getEnvironmentBlendMode();T==="additive"?e.buffers.color.setClear(0,0,0,1,r):T==="alpha-blend"&&e.buffers.color.setClear(0,0,0,0,r),(i.autoClear||M)&&(e.buffers.depth.setTest(!0),e.buffers.depth.setMask(!0),e.buffers.color.setMask(!0),i.clear(i.autoClearColor,i.autoClearDepth,i.autoClearStencil))}function x(_,M){let y=f(M);y&&y.isCubeTexture?(c===void 0&&(c=new me(new Fs(1,1,1),new Ln({name:"BackgroundCubeMaterial",uniforms:as(nn.backgroundCube.uniforms),vertexShader:nn.backgroundCube.vertexShader,fragmentShader:nn.backgroundCube.fragmentShader,side:Ae,depthTest:!1,depthWrite:!1,fog:!1,allowOverride:!1})),c.geometry.deleteAttribute("normal"),c.geometry.deleteAttribute("uv"),c.onBeforeRender=function(T,E,v){this.matrixWorld.copyPosition(v.matrixWorld)},Object.defineProperty(c.material,"envMap",{get:function(){return this.uniforms.envMap.value}}),n.update(c)),c.material.uniforms.envMap.value=y,c.material.uniforms.backgroundBlurriness.value=M.backgroundBlurriness,c.material.uniforms.backgroundIntensity.value=M.backgroundIntensity,c.material.uniforms.backgroundRotation.value.setFromMatrix4(Ey.makeRotationFromEuler(M.backgroundRotation)).transpose(),y.isRenderTargetTexture===!1&&c.material.uniforms.backgroundRotation.value.premultiply(Pp),c.material.toneMapped=Xt.getTransfer(y.colorSpace)!==Jt,(h!==y||d!==y.version||u!==i.toneMapping)&&(c.material.needsUpdate=!0,h=y,d=y.version,u=i.toneMapping),c.layers.enableAll(),_.unshift(c,c.geometry,c.material,0,0,null)):y&&y.isTexture&&(l===void 0&&(l=new me(new Ir(2,2),new Ln({name:"BackgroundMaterial",uniforms:as(nn.background.uniforms),vertexShader:nn.background.vertexShader,fragmentShader:nn.background.fragmentShader,side:zn,depthTest:!1,depthWrite:!1,fog:!1,allowOverride:!1})),l.geometry.deleteAttribute("normal"),Object.defineProperty(l.material,"map",{get:function(){return this.uniforms.t2D.value}}),n.update(l)),l.material.uniforms.t2D.value=y,l.material.uniforms.backgroundIntensity.value=M.backgroundIntensity,l.material.toneMapped=Xt.getTransfer(y.colorSpace)!==Jt,y.matrixAutoUpdate===!0&&y.updateMatrix(),l.material.uniforms.uvTransform.value.copy(y.matrix),(h!==y||d!==y.version||u!==i.toneMapping)&&(l.material.needsUpdate=!0,h=y,d=y.version,u=i.toneMapping),l.layers.enableAll(),_.unshift(l,l.geometry,l.material,0,0,null))}function p(_,M){_.getRGB(_l,nu(i)),e.buffers.color.setClear(_l.r,_l.g,_l.b,M,r)}function m(){c!==void 0&&(c.geometry.dispose(),c.material.dispose(),c=void 0),l!==void 0&&(l.geometry.dispose(),l.material.dispose(),l=void 0)}return{getClearColor:function(){return o},setClearColor:function(_,M=1){o.set(_),a=M,p(o,a)},getClearAlpha:function(){return a},setClearAlpha:function(_){a=_,p(o,a)},render:g,addToRenderList:x,dispose:m}}function Ty(i,t){let e=i.getParameter(i.MAX_VERTEX_ATTRIBS),n={},s=u(null),r=s,o=!1;function a(N,O,V,C,H){let X=!1,G=d(N,C,V,O);r!==G&&(r=G,c(r.object)),X=f(N,C,V,H),X&&g(N,C,V,H),H!==null&&t.update(H,i.ELEMENT_ARRAY_BUFFER),(X||o)&&(o=!1,y(N,O,V,C),H!==null&&i.bindBuffer(i.ELEMENT_ARRAY_BUFFER,t.get(H).buffer))}function l(){return i.createVertexArray()}function c(N){return i.bindVertexArray(N)}function h(N){return i.deleteVertexArray(N)}function d(N,O,V,C){let H=C.wireframe===!0,X=n[O.id];X===void 0&&(X={},n[O.id]=X);let G=N.isInstancedMesh===!0?N.id:0,nt=X[G];nt===void 0&&(nt={},X[G]=nt);let $=nt[V.id];$===void 0&&($={},nt[V.id]=$);let Q=$[H];return Q===void 0&&(Q=u(l()),$[H]=Q),Q}function u(N){let O=[],V=[],C=[];for(let H=0;H<e;H++)O[H]=0,V[H]=0,C[H]=0;return{geometry:null,program:null,wireframe:!1,newAttributes:O,enabledAttributes:V,attributeDivisors:C,object:N,attributes:{},index:null}}function f(N,O,V,C){let H=r.attributes,X=O.attributes,G=0,nt=V.getAttributes();for(let $ in nt)if(nt[$].location>=0){let et=H[$],yt=X[$];if(yt===void 0&&($==="instanceMatrix"&&N.instanceMatrix&&(yt=N.instanceMatrix),$==="instanceColor"&&N.instanceColor&&(yt=N.instanceColor)),et===void 0||et.attribute!==yt||yt&&et.data!==yt.data)return!0;G++}return r.attributesNum!==G||r.index!==C}function g(N,O,V,C){let H={},X=O.attributes,G=0,nt=V.getAttributes();for(let $ in nt)if(nt[$].location>=0){let et=X[$];et===void 0&&($==="instanceMatrix"&&N.instanceMatrix&&(et=N.instanceMatrix),$==="instanceColor"&&N.instanceColor&&(et=N.instanceColor));let yt={};yt.attribute=et,et&&et.data&&(yt.data=et.data),H[$]=yt,G++}r.attributes=H,r.attributesNum=G,r.index=C}function x(){let N=r.newAttributes;for(let O=0,V=N.length;O<V;O++)N[O]=0}function p(N){m(N,0)}function m(N,O){let V=r.newAttributes,C=r.enabledAttributes,H=r.attributeDivisors;V[N]=1,C[N]===0&&(i.enableVertexAttribArray(N),C[N]=1),H[N]!==O&&(i.vertexAttribDivisor(N,O),H[N]=O)}function _(){let N=r.newAttributes,O=r.enabledAttributes;for(let V=0,C=O.length;V<C;V++)O[V]!==N[V]&&(i.disableVertexAttribArray(V),O[V]=0)}function M(N,O,V,C,H,X,G){G===!0?i.vertexAttribIPointer(N,O,V,H,X):i.vertexAttribPointer(N,O,V,C,H,X)}function y(N,O,V,C){x();let H=C.attributes,X=V.getAttributes(),G=O.defaultAttributeValues;for(let nt in X){let $=X[nt];if($.location>=0){let Q=H[nt];if(Q===void 0&&(nt==="instanceMatrix"&&N.instanceMatrix&&(Q=N.instanceMatrix),nt==="instanceColor"&&N.instanceColor&&(Q=N.instanceColor)),Q!==void 0){let et=Q.normalized,yt=Q.itemSize,Dt=t.get(Q);if(Dt===void 0)continue;let Z=Dt.buffer,gt=Dt.type,bt=Dt.bytesPerElement,Rt=gt===i.INT||gt===i.UNSIGNED_INT||Q.gpuType===Ua;if(Q.isInterleavedBufferAttribute){let vt=Q.data,Bt=vt.isInterleavedBuffer===!0?vt.stride:vt.itemSize,xe=Q.offset;if(vt.isInstancedInterleavedBuffer||vt.isInstancedBufferAttribute){for(let It=0;It<$.locationSize;It++)m($.location+It,vt.meshPerAttribute);N.isInstancedMesh!==!0&&C._maxInstanceCount===void 0&&(C._maxInstanceCount=vt.meshPerAttribute*vt.count)}else for(let It=0;It<$.locationSize;It++)p($.location+It);i.bindBuffer(i.ARRAY_BUFFER,Z);for(let It=0;It<$.locationSize;It++)M($.location+It,yt/$.locationSize,gt,et,Bt*bt,(xe+yt/$.locationSize*It)*bt,Rt)}else{if(Q.isInstancedBufferAttribute){for(let vt=0;vt<$.locationSize;vt++)m($.location+vt,Q.meshPerAttribute);N.isInstancedMesh!==!0&&C._maxInstanceCount===void 0&&(C._maxInstanceCount=Q.meshPerAttribute*Q.count)}else for(let vt=0;vt<$.locationSize;vt++)p($.location+vt);i.bindBuffer(i.ARRAY_BUFFER,Z);for(let vt=0;vt<$.locationSize;vt++)M($.location+vt,yt/$.locationSize,gt,et,yt*bt,yt/$.locationSize*vt*bt,Rt)}}else if(G!==void 0){let et=G[nt];if(et!==void 0)switch(et.length){case 2:i.vertexAttrib2fv($.location,et);break;case 3:i.vertexAttrib3fv($.location,et);break;case 4:i.vertexAttrib4fv($.location,et);break;default:i.vertexAttrib1fv($.location,et)}}}}_()}function T(){F();for(let N in n){let O=n[N];for(let V in O){let C=O[V];for(let H in C){let X=C[H];for(let G in X)h(X[G].object),delete X[G];delete C[H]}}delete n[N]}}function E(N){if(n[N.id]===void 0)return;let O=n[N.id];for(let V in O){let C=O[V];for(let H in C){let X=C[H];for(let G in X)h(X[G].object),delete X[G];delete C[H]}}delete n[N.id]}function v(N){for(let O in n){let V=n[O];for(let C in V){let H=V[C];if(H[N.id]===void 0)continue;let X=H[N.id];for(let G in X)h(X[G].object),delete X[G];delete H[N.id]}}}function w(N){for(let O in n){let V=n[O],C=N.isInstancedMesh===!0?N.id:0,H=V[C];if(H!==void 0){for(let X in H){let G=H[X];for(let nt in G)h(G[nt].object),delete G[nt];delete H[X]}delete V[C],Object.keys(V).length===0&&delete n[O]}}}function F(){D(),o=!0,r!==s&&(r=s,c(r.object))}function D(){s.geometry=null,s.program=null,s.wireframe=!1}return{setup:a,reset:F,resetDefaultState:D,dispose:T,releaseStatesOfGeometry:E,releaseStatesOfObject:w,releaseStatesOfProgram:v,initAttributes:x,enableAttribute:p,disableUnusedAttributes:_}}function Cy(i,t,e){let n;function s(l){n=l}function r(l,c){i.drawArrays(n,l,c),e.update(c,n,1)}function o(l,c,h){h!==0&&(i.drawArraysInstanced(n,l,c,h),e.update(c,n,h))}function a(l,c,h){if(h===0)return;t.get("WEBGL_multi_draw").multiDrawArraysWEBGL(n,l,0,c,0,h);let u=0;for(let f=0;f<h;f++)u+=c[f];e.update(u,n,1)}this.setMode=s,this.render=r,this.renderInstances=o,this.renderMultiDraw=a}function Ry(i,t,e,n){let s;function r(){if(s!==void 0)return s;if(t.has("EXT_texture_filter_anisotropic")===!0){let v=t.get("EXT_texture_filter_anisotropic");s=i.getParameter(v.MAX_TEXTURE_MAX_ANISOTROPY_EXT)}else s=0;return s}function o(v){return!(v!==_n&&n.convert(v)!==i.getParameter(i.IMPLEMENTATION_COLOR_READ_FORMAT))}function a(v){let w=v===xn&&(t.has("EXT_color_buffer_half_float")||t.has("EXT_color_buffer_float"));return!(v!==vn&&v!==Gn&&!w&&n.convert(v)!==i.getParameter(i.IMPLEMENTATION_COLOR_READ_TYPE))}function l(v){if(v==="highp"){if(i.getShaderPrecisionFormat(i.VERTEX_SHADER,i.HIGH_FLOAT).precision>0&&i.getShaderPrecisionFormat(i.FRAGMENT_SHADER,i.HIGH_FLOAT).precision>0)return"highp";v="mediump"}return v==="mediump"&&i.getShaderPrecisionFormat(i.VERTEX_SHADER,i.MEDIUM_FLOAT).precision>0&&i.getShaderPrecisionFormat(i.FRAGMENT_SHADER,i.MEDIUM_FLOAT).precision>0?"mediump":"lowp"}let c=e.precision!==void 0?e.precision:"highp",h=l(c);h!==c&&(Tt("WebGLRenderer:",c,"not supported, using",h,"instead."),c=h);let d=e.reversedDepthBuffer===!0&&t.has("EXT_clip_control"),u=e.logarithmicDepthBuffer===!0&&d===!1;e.reversedDepthBuffer===!0&&d===!1&&Tt("WebGLRenderer: Unable to use reversed depth buffer due to missing EXT_clip_control extension. Fallback to default depth buffer."),e.logarithmicDepthBuffer===!0&&d===!0&&Tt("WebGLRenderer: Logarithmic depth buffer is ignored when reversed depth buffer is enabled.");let f=i.getParameter(i.MAX_TEXTURE_IMAGE_UNITS),g=i.getParameter(i.MAX_VERTEX_TEXTURE_IMAGE_UNITS),x=i.getParameter(i.MAX_TEXTURE_SIZE),p=i.getParameter(i.MAX_CUBE_MAP_TEXTURE_SIZE),m=i.getParameter(i.MAX_VERTEX_ATTRIBS),_=i.getParameter(i.MAX_VERTEX_UNIFORM_VECTORS),M=i.getParameter(i.MAX_VARYING_VECTORS),y=i.getParameter(i.MAX_FRAGMENT_UNIFORM_VECTORS),T=i.getParameter(i.MAX_SAMPLES),E=i.getParameter(i.SAMPLES);return{isWebGL2:!0,getMaxAnisotropy:r,getMaxPrecision:l,textureFormatReadable:o,textureTypeReadable:a,precision:c,logarithmicDepthBuffer:u,reversedDepthBuffer:d,maxTextures:f,maxVertexTextures:g,maxTextureSize:x,maxCubemapSize:p,maxAttributes:m,maxVertexUniforms:_,maxVaryings:M,maxFragmentUniforms:y,maxSamples:T,samples:E}}function Py(i){let t=this,e=null,n=0,s=!1,r=!1,o=new Xe,a=new Nt,l={value:null,needsUpdate:!1};this.uniform=l,this.numPlanes=0,this.numIntersection=0,this.init=function(d,u){let f=d.length!==0||u||n!==0||s;return s=u,n=d.length,f},this.beginShadows=function(){r=!0,h(null)},this.endShadows=function(){r=!1},this.setGlobalState=function(d,u){e=h(d,u,0)},this.setState=function(d,u,f){let g=d.clippingPlanes,x=d.clipIntersection,p=d.clipShadows,m=i.get(d);if(!s||g===null||g.length===0||r&&!p)r?h(null):c();else{let _=r?0:n,M=_*4,y=m.clippingState||null;l.value=y,y=h(g,u,M,f);for(let T=0;T!==M;++T)y[T]=e[T];m.clippingState=y,this.numIntersection=x?this.numPlanes:0,this.numPlanes+=_}};function c(){l.value!==e&&(l.value=e,l.needsUpdate=n>0),t.numPlanes=n,t.numIntersection=0}function h(d,u,f,g){let x=d!==null?d.length:0,p=null;if(x!==0){if(p=l.value,g!==!0||p===null){let m=f+x*4,_=u.matrixWorldInverse;a.getNormalMatrix(_),(p===null||p.length<m)&&(p=new Float32Array(m));for(let M=0,y=f;M!==x;++M,y+=4)o.copy(d[M]).applyMatrix4(_,a),o.normal.toArray(p,y),p[y+3]=o.constant}l.value=p,l.needsUpdate=!0}return t.numPlanes=x,t.numIntersection=0,p}}var Zr=class extends pn{constructor(t=1,e={}){super(t,t,e),this.isWebGLCubeRenderTarget=!0;let n={width:t,height:t,depth:1},s=[n,n,n,n,n,n];this.texture=new wr(s),this._setTextureOptions(e),this.texture.isRenderTargetTexture=!0}fromEquirectangularTexture(t,e){this.texture.type=e.type,this.texture.colorSpace=e.colorSpace,this.texture.generateMipmaps=e.generateMipmaps,this.texture.minFilter=e.minFilter,this.texture.magFilter=e.magFilter;let n={uniforms:{tEquirect:{value:null}},vertexShader:`

				varying vec3 vWorldDirection;

				vec3 transformDirection( in vec3 dir, in mat4 matrix ) {

					return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );

				}

				void main() {

					vWorldDirection = transformDirection( position, modelMatrix );

					#include <begin_vertex>
					#include <project_vertex>

				}
			`,fragmentShader:`

				uniform sampler2D tEquirect;

				varying vec3 vWorldDirection;

				#include <common>

				void main() {

					vec3 direction = normalize( vWorldDirection );

					vec2 sampleUV = equirectUv( direction );

					gl_FragColor = texture2D( tEquirect, sampleUV );

				}
			`},s=new Fs(5,5,5),r=new Ln({name:"CubemapFromEquirect",uniforms:as(n.uniforms),vertexShader:n.vertexShader,fragmentShader:n.fragmentShader,side:Ae,blending:is});r.uniforms.tEquirect.value=e;let o=new me(s,r),a=e.minFilter;return e.minFilter===gi&&(e.minFilter=Be),new ks(1,10,this).update(t,o),e.minFilter=a,o.geometry.dispose(),o.material.dispose(),this}clear(t,e=!0,n=!0,s=!0){let r=t.getRenderTarget();for(let o=0;o<6;o++)t.setRenderTarget(this,o),t.clear(e,n,s);t.setRenderTarget(r)}},lp=256,Iy=3,Ly=20,Ip=256,Lp=16,Dy=3,Ny=new P,Uy=new Gt,bl=class i{constructor(t){this._renderer=t,this._cubeSize=0,this._sourceTarget=null,this._cubeCamera=new ks(1,10,null),this._boxMesh=new me(new Fs(5,5,5),null),this._cubemapMaterial=null,this._equirectMaterial=null,this._blurMaterial=null,this._ggxMaterial=null,this._integrationMaterial=null}fromScene(t,e=0,n=.1,s=100,r={}){let{size:o=256,position:a=Ny}=r,l=this._renderer;this._setSize(o);let c=this._allocateTarget(),h=this._getSourceTarget(!0);e>0&&(h.texture.mipmapsAutoUpdate=!1);let d=l.autoClear,u=l.autoClearColor,f=l.autoClearDepth,g=l.autoClearStencil,x=t.background;l.autoClear=!0,l.autoClearColor=!0,l.autoClearDepth=!0,l.autoClearStencil=!0,x===null&&(t.background=l.getClearColor(Uy));let p=new ks(n,s,h);return p.position.copy(a),p.update(l,t),l.autoClear=d,l.autoClearColor=u,l.autoClearDepth=f,l.autoClearStencil=g,t.background=x,e>0&&(h.texture.mipmapsAutoUpdate=!0,this._blur(c,e)),this._applyPMREM(c),c}fromEquirectangular(t,e=null){return this._fromTexture(t,e)}fromCubemap(t,e=null){return this._fromTexture(t,e)}compileCubemapShader(){this._cubemapMaterial===null&&(this._cubemapMaterial=up(),this._compileMaterial(this._cubemapMaterial))}compileEquirectangularShader(){this._equirectMaterial===null&&(this._equirectMaterial=hp(),this._compileMaterial(this._equirectMaterial))}dispose(){this._sourceTarget!==null&&this._sourceTarget.dispose(),this._cubemapMaterial!==null&&this._cubemapMaterial.dispose(),this._equirectMaterial!==null&&this._equirectMaterial.dispose(),this._blurMaterial!==null&&this._blurMaterial.dispose(),this._ggxMaterial!==null&&this._ggxMaterial.dispose(),this._integrationMaterial!==null&&this._integrationMaterial.dispose(),this._boxMesh.geometry.dispose()}static lodToRoughness(t,e){return e>0?1-Math.sqrt(1-t/e):0}_setSize(t){this._cubeSize=Math.max(lp,Qh(t))}_fromTexture(t,e){t.mapping===rs||t.mapping===Gs?this._setSize(t.image.length===0?lp:t.image[0].width||t.image[0].image.width):this._setSize(t.image.width/4);let n=e||this._allocateTarget();return this._textureToCubemap(t),this._applyPMREM(n),n}_allocateTarget(){let t=this._cubeSize,e=cp(t,!1,!1),n=Math.log2(t)-Iy;for(let s=0;s<=n;s++)e.texture.mipmaps.push({width:t>>s,height:t>>s});return e.texture.name="PMREM",e.texture.isPMREMTexture=!0,e}_getSourceTarget(t=!1){let e=this._cubeSize,n=this._sourceTarget;return(n===null||n.width!==e||t&&n.depthBuffer===!1)&&(n!==null&&n.dispose(),this._sourceTarget=cp(e,!0,t)),this._sourceTarget}_compileMaterial(t){this._boxMesh.material=t,this._renderer.compile(this._boxMesh,this._cubeCamera.children[0])}_renderCube(t,e,n){let s=this._boxMesh,r=this._cubeCamera;s.material=n,r.renderTarget=t,r.activeMipmapLevel=e;let o=t.width>>e;t.viewport.set(0,0,o,o),r.update(this._renderer,s),t.viewport.set(0,0,t.width,t.height)}_textureToCubemap(t){let e;t.mapping===rs||t.mapping===Gs?(this._cubemapMaterial===null&&(this._cubemapMaterial=up()),e=this._cubemapMaterial,e.uniforms.flipEnvMap.value=t.isRenderTargetTexture===!1?-1:1):(this._equirectMaterial===null&&(this._equirectMaterial=hp()),e=this._equirectMaterial),e.uniforms.envMap.value=t,this._renderCube(this._getSourceTarget(),0,e)}_applyPMREM(t){this._ggxMaterial===null&&(this._ggxMaterial=Fy(),this._integrationMaterial=Oy());let e=this._cubeSize,n=t.texture.mipmaps.length-1,s=this._ggxMaterial.uniforms;s.envMap.value=this._sourceTarget.texture;let r=this._integrationMaterial.uniforms;r.envMap.value=this._sourceTarget.texture,r.sourceLod.value=Math.log2(e/Lp);for(let o=0;o<=n;o++){let a=i.lodToRoughness(o,n);if(o>n-Dy)r.roughness.value=a,this._renderCube(t,o,this._integrationMaterial);else{let l=a>0?Math.log2(e)+.5*Math.log2(6/(Ip*Math.pow(a,4)))+.5:0;s.roughness.value=a,s.lodBias.value=l,this._renderCube(t,o,this._ggxMaterial)}}}_blur(t,e){this._blurMaterial===null&&(this._blurMaterial=By());let n=this._blurMaterial,s=n.uniforms,r=this._sourceTarget;s.sigma.value=Math.min(e,Math.PI)/Math.SQRT2,s.envMap.value=r.texture,this._renderCube(t,0,n),s.envMap.value=t.texture,this._renderCube(r,0,n)}};function cp(i,t,e){return new Zr(i,{minFilter:gi,generateMipmaps:t,type:xn,colorSpace:mr,depthBuffer:e})}function Kr(i,t,e){return new Ln({name:i,uniforms:t,vertexShader:Ht.cube_vert,fragmentShader:e,side:Ae,blending:is,depthTest:!1,depthWrite:!1})}function Fy(){return Kr("PMREMGGXConvolution",{envMap:{value:null},roughness:{value:0},lodBias:{value:0}},`

		#define GGX_SAMPLES ${Ip}u

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float roughness;
		uniform float lodBias;

		#include <common>

		// Van der Corput radical inverse
		float radicalInverse_VdC( uint bits ) {

			bits = ( bits << 16u ) | ( bits >> 16u );
			bits = ( ( bits & 0x55555555u ) << 1u ) | ( ( bits & 0xAAAAAAAAu ) >> 1u );
			bits = ( ( bits & 0x33333333u ) << 2u ) | ( ( bits & 0xCCCCCCCCu ) >> 2u );
			bits = ( ( bits & 0x0F0F0F0Fu ) << 4u ) | ( ( bits & 0xF0F0F0F0u ) >> 4u );
			bits = ( ( bits & 0x00FF00FFu ) << 8u ) | ( ( bits & 0xFF00FF00u ) >> 8u );
			return float( bits ) * 2.3283064365386963e-10; // / 0x100000000

		}

		// Hammersley sequence
		vec2 hammersley( uint i, uint N ) {

			return vec2( float( i ) / float( N ), radicalInverse_VdC( i ) );

		}

		void main() {

			vec3 N = normalize( vWorldDirection );

			// For very low roughness, just sample the environment directly
			if ( roughness < 0.001 ) {

				gl_FragColor = vec4( textureLod( envMap, N, 0.0 ).rgb, 1.0 );
				return;

			}

			float alpha = roughness * roughness;
			float alpha2 = alpha * alpha;

			// Tangent space basis for VNDF sampling
			vec3 up = abs( N.z ) < 0.999 ? vec3( 0.0, 0.0, 1.0 ) : vec3( 1.0, 0.0, 0.0 );
			vec3 tangent = normalize( cross( up, N ) );
			vec3 bitangent = cross( N, tangent );

			vec3 prefilteredColor = vec3( 0.0 );
			float totalWeight = 0.0;

			for ( uint i = 0u; i < GGX_SAMPLES; i ++ ) {

				vec2 Xi = hammersley( i, GGX_SAMPLES );

				// With V = N, sample the reflected direction directly.
				float invQ = 1.0 / ( 1.0 - Xi.x + alpha2 * Xi.x );
				float NdotL = ( 1.0 - Xi.x - alpha2 * Xi.x ) * invQ;

				if ( NdotL > 0.0 ) {

					float phi = 2.0 * PI * Xi.y;
					float sinTheta = 2.0 * alpha * sqrt( Xi.x * ( 1.0 - Xi.x ) ) * invQ;
					vec3 L = N * NdotL + ( tangent * cos( phi ) + bitangent * sin( phi ) ) * sinTheta;

					// Match the source mip to the sample's solid angle. The terms
					// independent of the sample are precomputed in lodBias.
					float d = alpha2 * invQ;
					float lod = max( log2( d ) + lodBias, 0.0 );

					// Weight by NdotL for the split-sum approximation
					prefilteredColor += textureLod( envMap, L, lod ).rgb * NdotL;
					totalWeight += NdotL;

				}

			}

			gl_FragColor = vec4( prefilteredColor / totalWeight, 1.0 );

		}
	`)}function Oy(){return Kr("PMREMGGXIntegration",{envMap:{value:null},roughness:{value:0},sourceLod:{value:0},sourceSize:{value:Lp}},`

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float roughness;
		uniform float sourceLod;
		uniform int sourceSize;

		void main() {

			vec3 N = normalize( vWorldDirection );

			float alpha = roughness * roughness;
			float alpha2 = alpha * alpha;

			float texelSize = 2.0 / float( sourceSize );

			vec3 prefilteredColor = vec3( 0.0 );
			float totalWeight = 0.0;

			// Pair opposite texels: only the one in N's hemisphere contributes.
			for ( int face = 0; face < 3; face ++ ) {

				for ( int y = 0; y < sourceSize; y ++ ) {

					for ( int x = 0; x < sourceSize; x ++ ) {

						vec2 uv = ( vec2( x, y ) + 0.5 ) * texelSize - 1.0;
						vec3 texelDirection = face == 0 ? vec3( 1.0, uv ) : ( face == 1 ? vec3( uv.x, 1.0, uv.y ) : vec3( uv, 1.0 ) );

						float invDistance = inversesqrt( 1.0 + dot( uv, uv ) );
						float NdotL = dot( N, texelDirection );
						texelDirection *= NdotL < 0.0 ? - 1.0 : 1.0;
						NdotL = abs( NdotL ) * invDistance;

						// With V = N, NdotH squared is ( 1 + NdotL ) / 2. Common factors
						// in the GGX distribution and texel solid angle cancel when normalized.
						float d = 1.0 + alpha2 + ( alpha2 - 1.0 ) * NdotL;
						float weight = NdotL * invDistance * invDistance * invDistance / ( d * d );

						prefilteredColor += textureLod( envMap, texelDirection, sourceLod ).rgb * weight;
						totalWeight += weight;

					}

				}

			}

			gl_FragColor = vec4( prefilteredColor / totalWeight, 1.0 );

		}
	`)}function By(){return Kr("PMREMSphericalGaussianBlur",{envMap:{value:null},sigma:{value:0}},`

		#define SAMPLES ${Ly}
		#define GOLDEN_ANGLE 2.39996322973

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float sigma;

		#include <common>

		void main() {

			vec3 outputDirection = normalize( vWorldDirection );

			vec3 up = abs( outputDirection.z ) < 0.999 ? vec3( 0.0, 0.0, 1.0 ) : vec3( 1.0, 0.0, 0.0 );
			vec3 tangent = normalize( cross( up, outputDirection ) );
			vec3 bitangent = cross( outputDirection, tangent );

			// Truncate the kernel at three standard deviations or at the antipode.
			float thetaMax = min( 3.0 * sigma, PI );
			float truncation = 1.0 - exp( - 0.5 * thetaMax * thetaMax / ( sigma * sigma ) );

			vec3 accumColor = vec3( 0.0 );
			float accumWeight = 0.0;

			for ( int i = 0; i < SAMPLES; i ++ ) {

				// Stratified inverse-CDF sampling of the Gaussian, placed on a golden-angle spiral.
				float stratum = ( float( i ) + 0.5 ) / float( SAMPLES );
				float theta = sigma * sqrt( - 2.0 * log( 1.0 - stratum * truncation ) );
				float phi = float( i ) * GOLDEN_ANGLE;

				vec3 offset = cos( phi ) * tangent + sin( phi ) * bitangent;
				vec3 sampleDirection = cos( theta ) * outputDirection + sin( theta ) * offset;

				// Correct the planar sample density to solid angle.
				float weight = sin( theta ) / theta;

				accumColor += weight * textureLod( envMap, sampleDirection, 0.0 ).rgb;
				accumWeight += weight;

			}

			gl_FragColor = vec4( accumColor / accumWeight, 1.0 );

		}
	`)}function hp(){return Kr("PMREMEquirectangularToCubemap",{envMap:{value:null}},`

		varying vec3 vWorldDirection;

		uniform sampler2D envMap;

		#include <common>

		void main() {

			// Average four subpixel samples to preserve small, bright features.
			vec3 direction = normalize( vWorldDirection );
			vec3 dx = dFdx( direction ) * 0.25;
			vec3 dy = dFdy( direction ) * 0.25;

			vec3 color = textureLod( envMap, equirectUv( normalize( direction - dx - dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction + dx - dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction - dx + dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction + dx + dy ) ), 0.0 ).rgb;
			gl_FragColor = vec4( color * 0.25, 1.0 );

		}
	`)}function up(){return Kr("PMREMCubemapToCubemap",{envMap:{value:null},flipEnvMap:{value:-1}},`

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float flipEnvMap;

		void main() {

			gl_FragColor = vec4( textureCube( envMap, vec3( flipEnvMap * vWorldDirection.x, vWorldDirection.yz ) ).rgb, 1.0 );

		}
	`)}function ky(i){let t=new WeakMap,e=new WeakMap,n=null;function s(u,f=!1){return u==null?null:f?o(u):r(u)}function r(u){if(u&&u.isTexture){let f=u.mapping;if(f===La||f===Da)if(t.has(u)){let g=t.get(u).texture;return a(g,u.mapping)}else{let g=u.image;if(g&&g.height>0){let x=new Zr(g.height);return x.fromEquirectangularTexture(i,u),t.set(u,x),u.addEventListener("dispose",c),a(x.texture,u.mapping)}else return null}}return u}function o(u){if(u&&u.isTexture&&u.isPMREMTexture!==!0){let f=u.mapping,g=f===La||f===Da,x=f===rs||f===Gs;if(g||x){let p=e.get(u),m=p!==void 0?p.texture.pmremVersion:0;if(u.isRenderTargetTexture&&u.pmremVersion!==m)return n===null&&(n=new bl(i)),p=g?n.fromEquirectangular(u,p):n.fromCubemap(u,p),p.texture.pmremVersion=u.pmremVersion,e.set(u,p),p.texture;if(p!==void 0)return p.texture;{let _=u.image;return g&&_&&_.height>0||x&&_&&l(_)?(n===null&&(n=new bl(i)),p=g?n.fromEquirectangular(u):n.fromCubemap(u),p.texture.pmremVersion=u.pmremVersion,e.set(u,p),u.addEventListener("dispose",h),p.texture):null}}}return u}function a(u,f){return f===La?u.mapping=rs:f===Da&&(u.mapping=Gs),u}function l(u){let f=0,g=6;for(let x=0;x<g;x++)u[x]!==void 0&&f++;return f===g}function c(u){let f=u.target;f.removeEventListener("dispose",c);let g=t.get(f);g!==void 0&&(t.delete(f),g.dispose())}function h(u){let f=u.target;f.removeEventListener("dispose",h);let g=e.get(f);g!==void 0&&(e.delete(f),g.dispose())}function d(){t=new WeakMap,e=new WeakMap,n!==null&&(n.dispose(),n=null)}return{get:s,dispose:d}}function zy(i){let t={};function e(n){if(t[n]!==void 0)return t[n];let s=i.getExtension(n);return t[n]=s,s}return{has:function(n){return e(n)!==null},init:function(){e("EXT_color_buffer_float"),e("WEBGL_clip_cull_distance"),e("OES_texture_float_linear"),e("EXT_color_buffer_half_float"),e("WEBGL_multisampled_render_to_texture"),e("WEBGL_render_shared_exponent")},get:function(n){let s=e(n);return s===null&&ur("WebGLRenderer: "+n+" extension not supported."),s}}}function Hy(i,t,e,n){let s={},r=new WeakMap,o=new FinalizationRegistry(g=>delete s[g]);function a(g){l(g.target)}function l(g){g.index!==null&&t.remove(g.index);for(let p in g.attributes)t.remove(g.attributes[p]);g.removeEventListener("dispose",a),delete s[g.id],o.unregister(g);let x=r.get(g);x&&(t.remove(x),r.delete(g)),n.releaseStatesOfGeometry(g),g.isInstancedBufferGeometry===!0&&delete g._maxInstanceCount,e.memory.geometries--}function c(g,x){return s[x.id]!==void 0||(x.addEventListener("dispose",a),s[x.id]=new WeakRef(x),o.register(x,x.id,x),e.memory.geometries++),x}function h(g){let x=g.attributes;for(let p in x)t.update(x[p],i.ARRAY_BUFFER)}function d(g){let x=g.index,p=g.attributes.position,m=0;if(p===void 0)return;let _=x!==null?x.array.length:p.array.length/3-1,M=p.count>=65535?Mr:Sr,y=new M(Math.ceil(_/3)*6,1),T=y.array;if(x!==null){let v=x.array;m=x.version;for(let w=0,F=0;w<_;w+=3){let D=v[w+0],N=v[w+1],O=v[w+2];T[F++]=D,T[F++]=N,T[F++]=N,T[F++]=O,T[F++]=O,T[F++]=D}}else{m=p.version;for(let v=0,w=0;v<_;v+=3){let F=v+0,D=v+1,N=v+2;T[w++]=F,T[w++]=D,T[w++]=D,T[w++]=N,T[w++]=N,T[w++]=F}}y.version=m;let E=r.get(g);E&&t.remove(E),r.set(g,y)}function u(g){let x=r.get(g);if(x){let p=g.index;p!==null&&x.version<p.version&&d(g)}else d(g);return r.get(g)}function f(){for(let g in s){let x=s[g].deref();x!==void 0&&l(x)}}return{get:c,update:h,getWireframeAttribute:u,dispose:f}}function Gy(i,t,e){let n;function s(d){n=d}let r,o;function a(d){r=d.type,o=d.bytesPerElement}function l(d,u){i.drawElements(n,u,r,d*o),e.update(u,n,1)}function c(d,u,f){f!==0&&(i.drawElementsInstanced(n,u,r,d*o,f),e.update(u,n,f))}function h(d,u,f){if(f===0)return;t.get("WEBGL_multi_draw").multiDrawElementsWEBGL(n,u,0,r,d,0,f);let x=0;for(let p=0;p<f;p++)x+=u[p];e.update(x,n,1)}this.setMode=s,this.setIndex=a,this.render=l,this.renderInstances=c,this.renderMultiDraw=h}function Vy(i){let t={geometries:0,textures:0},e={frame:0,calls:0,triangles:0,points:0,lines:0};function n(r,o,a){switch(e.calls++,o){case i.TRIANGLES:e.triangles+=a*(r/3);break;case i.LINES:e.lines+=a*(r/2);break;case i.LINE_STRIP:e.lines+=a*(r-1);break;case i.LINE_LOOP:e.lines+=a*r;break;case i.POINTS:e.points+=a*r;break;default:Lt("WebGLInfo: Unknown draw mode:",o);break}}function s(){e.calls=0,e.triangles=0,e.points=0,e.lines=0}return{memory:t,render:e,programs:null,autoReset:!0,reset:s,update:n}}function Wy(i,t,e){let n=new WeakMap,s=new ne;function r(o,a,l){let c=o.morphTargetInfluences,h=a.morphAttributes.position||a.morphAttributes.normal||a.morphAttributes.color,d=h!==void 0?h.length:0,u=n.get(a);if(u===void 0||u.count!==d){let F=function(){v.dispose(),n.delete(a),a.removeEventListener("dispose",F)};u!==void 0&&u.texture.dispose();let f=a.morphAttributes.position!==void 0,g=a.morphAttributes.normal!==void 0,x=a.morphAttributes.color!==void 0,p=a.morphAttributes.position||[],m=a.morphAttributes.normal||[],_=a.morphAttributes.color||[],M=0;f===!0&&(M=1),g===!0&&(M=2),x===!0&&(M=3);let y=a.attributes.position.count*M,T=1;y>t.maxTextureSize&&(T=Math.ceil(y/t.maxTextureSize),y=t.maxTextureSize);let E=new Float32Array(y*T*4*d),v=new yr(E,y,T,d);v.type=Gn,v.needsUpdate=!0;let w=M*4;for(let D=0;D<d;D++){let N=p[D],O=m[D],V=_[D],C=y*T*4*D;for(let H=0;H<N.count;H++){let X=H*w;f===!0&&(s.fromBufferAttribute(N,H),E[C+X+0]=s.x,E[C+X+1]=s.y,E[C+X+2]=s.z,E[C+X+3]=0),g===!0&&(s.fromBufferAttribute(O,H),E[C+X+4]=s.x,E[C+X+5]=s.y,E[C+X+6]=s.z,E[C+X+7]=0),x===!0&&(s.fromBufferAttribute(V,H),E[C+X+8]=s.x,E[C+X+9]=s.y,E[C+X+10]=s.z,E[C+X+11]=V.itemSize===4?s.w:1)}}u={count:d,texture:v,size:new Ct(y,T)},n.set(a,u),a.addEventListener("dispose",F)}if(o.isInstancedMesh===!0&&o.morphTexture!==null)l.getUniforms().setValue(i,"morphTexture",o.morphTexture,e);else{let f=0;for(let x=0;x<c.length;x++)f+=c[x];let g=a.morphTargetsRelative?1:1-f;l.getUniforms().setValue(i,"morphTargetBaseInfluence",g),l.getUniforms().setValue(i,"morphTargetInfluences",c)}l.getUniforms().setValue(i,"morphTargetsTexture",u.texture,e),l.getUniforms().setValue(i,"morphTargetsTextureSize",u.size)}return{update:r}}function $y(i,t,e,n,s){let r=new WeakMap;function o(c){let h=s.render.frame,d=c.geometry,u=t.get(c,d);if(r.get(u)!==h&&(t.update(u),r.set(u,h)),c.isInstancedMesh&&(c.hasEventListener("dispose",l)===!1&&c.addEventListener("dispose",l),r.get(c)!==h&&(e.update(c.instanceMatrix,i.ARRAY_BUFFER),c.instanceColor!==null&&e.update(c.instanceColor,i.ARRAY_BUFFER),r.set(c,h))),c.isSkinnedMesh){let f=c.skeleton;r.get(f)!==h&&(f.update(),r.set(f,h))}return u}function a(){r=new WeakMap}function l(c){let h=c.target;h.removeEventListener("dispose",l),n.releaseStatesOfObject(h),e.remove(h.instanceMatrix),h.instanceColor!==null&&e.remove(h.instanceColor)}return{update:o,dispose:a}}var Xy={[Ch]:"LINEAR_TONE_MAPPING",[Rh]:"REINHARD_TONE_MAPPING",[Ph]:"CINEON_TONE_MAPPING",[Ih]:"ACES_FILMIC_TONE_MAPPING",[Dh]:"AGX_TONE_MAPPING",[Nh]:"NEUTRAL_TONE_MAPPING",[Lh]:"CUSTOM_TONE_MAPPING"};function qy(i,t,e,n,s,r){let o=new pn(t,e,{type:i,depthBuffer:s,stencilBuffer:r,samples:n?4:0,storeMultisampledDepthBuffer:!1,storeMultisampledStencilBuffer:!1,resolveDepthBuffer:!1,resolveStencilBuffer:!1}),a=null,l=null,c=null,h=new he;h.setAttribute("position",new Qt([-1,3,0,-1,-1,0,3,-1,0],3)),h.setAttribute("uv",new Qt([0,2,0,0,2,0],2));let d=new xa({uniforms:{tDiffuse:{value:null}},vertexShader:`
			precision highp float;

			uniform mat4 modelViewMatrix;
			uniform mat4 projectionMatrix;

			attribute vec3 position;
			attribute vec2 uv;

			varying vec2 vUv;

			void main() {
				vUv = uv;
				gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 );
			}`,fragmentShader:`
			precision highp float;

			uniform sampler2D tDiffuse;

			varying vec2 vUv;

			#include <tonemapping_pars_fragment>
			#include <colorspace_pars_fragment>

			void main() {
				gl_FragColor = texture2D( tDiffuse, vUv );

				#ifdef LINEAR_TONE_MAPPING
					gl_FragColor.rgb = LinearToneMapping( gl_FragColor.rgb );
				#elif defined( REINHARD_TONE_MAPPING )
					gl_FragColor.rgb = ReinhardToneMapping( gl_FragColor.rgb );
				#elif defined( CINEON_TONE_MAPPING )
					gl_FragColor.rgb = CineonToneMapping( gl_FragColor.rgb );
				#elif defined( ACES_FILMIC_TONE_MAPPING )
					gl_FragColor.rgb = ACESFilmicToneMapping( gl_FragColor.rgb );
				#elif defined( AGX_TONE_MAPPING )
					gl_FragColor.rgb = AgXToneMapping( gl_FragColor.rgb );
				#elif defined( NEUTRAL_TONE_MAPPING )
					gl_FragColor.rgb = NeutralToneMapping( gl_FragColor.rgb );
				#elif defined( CUSTOM_TONE_MAPPING )
					gl_FragColor.rgb = CustomToneMapping( gl_FragColor.rgb );
				#endif

				#ifdef SRGB_TRANSFER
					gl_FragColor = sRGBTransferOETF( gl_FragColor );
				#endif
			}`,depthTest:!1,depthWrite:!1}),u=new me(h,d),f=new Bs(-1,1,1,-1,0,1),g=null,x=null,p=!1,m,_=null,M=[],y=!1;this.setSize=function(T,E){o.setSize(T,E),a!==null&&a.setSize(T,E),l!==null&&l.setSize(T,E);for(let v=0;v<M.length;v++){let w=M[v];w.setSize&&w.setSize(T,E)}},this.setEffects=function(T){M=T,y=M.length>0&&M[0].isRenderPass===!0;let E=o.width,v=o.height;M.length>0&&a===null&&(a=new pn(E,v,{type:xn,depthBuffer:!1,stencilBuffer:!1}),l=new pn(E,v,{type:xn,depthBuffer:!1,stencilBuffer:!1}));let w=s===!0&&M.some(F=>F.needsDepthTexture===!0);w!==(o.depthTexture!==null)&&(w===!0&&c===null&&(c=new mi(E,v),r===!0&&(c.format=vi,c.type=os)),o.dispose(),o.depthTexture=w?c:null,o.resolveDepthBuffer=w,o.storeMultisampledDepthBuffer=w);for(let F=0;F<M.length;F++){let D=M[F];D.setSize&&D.setSize(E,v),w&&D.needsDepthTexture===!0&&D.setDepthTexture&&D.setDepthTexture(c)}},this.begin=function(T,E){if(p||T.toneMapping===Zn&&M.length===0)return!1;if(_=E,E!==null){let v=E.width,w=E.height;(o.width!==v||o.height!==w)&&this.setSize(v,w)}return y===!1&&T.setRenderTarget(o),m=T.toneMapping,T.toneMapping=Zn,!0},this.hasRenderPass=function(){return y},this.end=function(T,E){T.toneMapping=m,p=!0;let v=o,w=a;for(let F=0;F<M.length;F++){let D=M[F];D.enabled!==!1&&(D.render(T,w,v,E),D.needsSwap!==!1&&(v=w,w=w===a?l:a))}if(g!==T.outputColorSpace||x!==T.toneMapping){g=T.outputColorSpace,x=T.toneMapping,d.defines={},Xt.getTransfer(g)===Jt&&(d.defines.SRGB_TRANSFER="");let F=Xy[x];F&&(d.defines[F]=""),d.needsUpdate=!0}d.uniforms.tDiffuse.value=v.texture,T.setRenderTarget(_),T.render(u,f),_=null,p=!1},this.isCompositing=function(){return p},this.dispose=function(){o.dispose(),a!==null&&a.dispose(),l!==null&&l.dispose(),h.dispose(),d.dispose()}}var Dp=new on,Np=new mi(1,1),Up=new Er(1),Fp=new yr,Op=new da,Bp=new wr,dp=[],fp=[],pp=new Float32Array(16),mp=new Float32Array(9),gp=new Float32Array(4);function $s(i,t,e){let n=i[0];if(n<=0||n>0)return i;let s=t*e,r=dp[s];if(r===void 0&&(r=new Float32Array(s),dp[s]=r),t!==0){n.toArray(r,0);for(let o=1,a=0;o!==t;++o)a+=e,i[o].toArray(r,a)}return r}function Te(i,t){if(i.length!==t.length)return!1;for(let e=0,n=i.length;e<n;e++)if(i[e]!==t[e])return!1;return!0}function Ce(i,t){for(let e=0,n=t.length;e<n;e++)i[e]=t[e]}function Ml(i,t){let e=fp[t];e===void 0&&(e=new Int32Array(t),fp[t]=e);for(let n=0;n!==t;++n)e[n]=i.allocateTextureUnit();return e}function Yy(i,t){let e=this.cache;e[0]!==t&&(i.uniform1f(this.addr,t),e[0]=t)}function jy(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y)&&(i.uniform2f(this.addr,t.x,t.y),e[0]=t.x,e[1]=t.y);else{if(Te(e,t))return;i.uniform2fv(this.addr,t),Ce(e,t)}}function Zy(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z)&&(i.uniform3f(this.addr,t.x,t.y,t.z),e[0]=t.x,e[1]=t.y,e[2]=t.z);else if(t.r!==void 0)(e[0]!==t.r||e[1]!==t.g||e[2]!==t.b)&&(i.uniform3f(this.addr,t.r,t.g,t.b),e[0]=t.r,e[1]=t.g,e[2]=t.b);else{if(Te(e,t))return;i.uniform3fv(this.addr,t),Ce(e,t)}}function Ky(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z||e[3]!==t.w)&&(i.uniform4f(this.addr,t.x,t.y,t.z,t.w),e[0]=t.x,e[1]=t.y,e[2]=t.z,e[3]=t.w);else{if(Te(e,t))return;i.uniform4fv(this.addr,t),Ce(e,t)}}function Jy(i,t){let e=this.cache,n=t.elements;if(n===void 0){if(Te(e,t))return;i.uniformMatrix2fv(this.addr,!1,t),Ce(e,t)}else{if(Te(e,n))return;gp.set(n),i.uniformMatrix2fv(this.addr,!1,gp),Ce(e,n)}}function Qy(i,t){let e=this.cache,n=t.elements;if(n===void 0){if(Te(e,t))return;i.uniformMatrix3fv(this.addr,!1,t),Ce(e,t)}else{if(Te(e,n))return;mp.set(n),i.uniformMatrix3fv(this.addr,!1,mp),Ce(e,n)}}function tb(i,t){let e=this.cache,n=t.elements;if(n===void 0){if(Te(e,t))return;i.uniformMatrix4fv(this.addr,!1,t),Ce(e,t)}else{if(Te(e,n))return;pp.set(n),i.uniformMatrix4fv(this.addr,!1,pp),Ce(e,n)}}function eb(i,t){let e=this.cache;e[0]!==t&&(i.uniform1i(this.addr,t),e[0]=t)}function nb(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y)&&(i.uniform2i(this.addr,t.x,t.y),e[0]=t.x,e[1]=t.y);else{if(Te(e,t))return;i.uniform2iv(this.addr,t),Ce(e,t)}}function ib(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z)&&(i.uniform3i(this.addr,t.x,t.y,t.z),e[0]=t.x,e[1]=t.y,e[2]=t.z);else{if(Te(e,t))return;i.uniform3iv(this.addr,t),Ce(e,t)}}function sb(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z||e[3]!==t.w)&&(i.uniform4i(this.addr,t.x,t.y,t.z,t.w),e[0]=t.x,e[1]=t.y,e[2]=t.z,e[3]=t.w);else{if(Te(e,t))return;i.uniform4iv(this.addr,t),Ce(e,t)}}function rb(i,t){let e=this.cache;e[0]!==t&&(i.uniform1ui(this.addr,t),e[0]=t)}function ob(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y)&&(i.uniform2ui(this.addr,t.x,t.y),e[0]=t.x,e[1]=t.y);else{if(Te(e,t))return;i.uniform2uiv(this.addr,t),Ce(e,t)}}function ab(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z)&&(i.uniform3ui(this.addr,t.x,t.y,t.z),e[0]=t.x,e[1]=t.y,e[2]=t.z);else{if(Te(e,t))return;i.uniform3uiv(this.addr,t),Ce(e,t)}}function lb(i,t){let e=this.cache;if(t.x!==void 0)(e[0]!==t.x||e[1]!==t.y||e[2]!==t.z||e[3]!==t.w)&&(i.uniform4ui(this.addr,t.x,t.y,t.z,t.w),e[0]=t.x,e[1]=t.y,e[2]=t.z,e[3]=t.w);else{if(Te(e,t))return;i.uniform4uiv(this.addr,t),Ce(e,t)}}function wl(i){return i.version===0&&(i.compareFunction=jh,i.needsUpdate=!0),i}function cb(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s);let r;this.type===i.SAMPLER_2D_SHADOW?r=wl(Np):r=Dp,e.setTexture2D(t||r,s)}function hb(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s),e.setTexture3D(t||Op,s)}function ub(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s);let r;this.type===i.SAMPLER_CUBE_SHADOW?r=wl(Up):r=Bp,e.setTextureCube(t||r,s)}function db(i,t,e){let n=this.cache,s=e.allocateTextureUnit();n[0]!==s&&(i.uniform1i(this.addr,s),n[0]=s),e.setTexture2DArray(t||Fp,s)}function fb(i){switch(i){case 5126:return Yy;case 35664:return jy;case 35665:return Zy;case 35666:return Ky;case 35674:return Jy;case 35675:return Qy;case 35676:return tb;case 5124:case 35670:return eb;case 35667:case 35671:return nb;case 35668:case 35672:return ib;case 35669:case 35673:return sb;case 5125:return rb;case 36294:return ob;case 36295:return ab;case 36296:return lb;case 35678:case 36198:case 36298:case 36306:case 35682:return cb;case 35679:case 36299:case 36307:return hb;case 35680:case 36300:case 36308:case 36293:return ub;case 36289:case 36303:case 36311:case 36292:return db}}function pb(i,t){i.uniform1fv(this.addr,t)}function mb(i,t){let e=$s(t,this.size,2);i.uniform2fv(this.addr,e)}function gb(i,t){let e=$s(t,this.size,3);i.uniform3fv(this.addr,e)}function vb(i,t){let e=$s(t,this.size,4);i.uniform4fv(this.addr,e)}function xb(i,t){let e=$s(t,this.size,4);i.uniformMatrix2fv(this.addr,!1,e)}function _b(i,t){let e=$s(t,this.size,9);i.uniformMatrix3fv(this.addr,!1,e)}function yb(i,t){let e=$s(t,this.size,16);i.uniformMatrix4fv(this.addr,!1,e)}function bb(i,t){i.uniform1iv(this.addr,t)}function Sb(i,t){i.uniform2iv(this.addr,t)}function Mb(i,t){i.uniform3iv(this.addr,t)}function wb(i,t){i.uniform4iv(this.addr,t)}function Eb(i,t){i.uniform1uiv(this.addr,t)}function Ab(i,t){i.uniform2uiv(this.addr,t)}function Tb(i,t){i.uniform3uiv(this.addr,t)}function Cb(i,t){i.uniform4uiv(this.addr,t)}function Rb(i,t,e){let n=this.cache,s=t.length,r=Ml(e,s);Te(n,r)||(i.uniform1iv(this.addr,r),Ce(n,r));let o;this.type===i.SAMPLER_2D_SHADOW?o=wl(Np):o=Dp;for(let a=0;a!==s;++a)e.setTexture2D(t[a]||o,r[a])}function Pb(i,t,e){let n=this.cache,s=t.length,r=Ml(e,s);Te(n,r)||(i.uniform1iv(this.addr,r),Ce(n,r));for(let o=0;o!==s;++o)e.setTexture3D(t[o]||Op,r[o])}function Ib(i,t,e){let n=this.cache,s=t.length,r=Ml(e,s);Te(n,r)||(i.uniform1iv(this.addr,r),Ce(n,r));let o;this.type===i.SAMPLER_CUBE_SHADOW?o=wl(Up):o=Bp;for(let a=0;a!==s;++a)e.setTextureCube(t[a]||o,r[a])}function Lb(i,t,e){let n=this.cache,s=t.length,r=Ml(e,s);Te(n,r)||(i.uniform1iv(this.addr,r),Ce(n,r));for(let o=0;o!==s;++o)e.setTexture2DArray(t[o]||Fp,r[o])}function Db(i){switch(i){case 5126:return pb;case 35664:return mb;case 35665:return gb;case 35666:return vb;case 35674:return xb;case 35675:return _b;case 35676:return yb;case 5124:case 35670:return bb;case 35667:case 35671:return Sb;case 35668:case 35672:return Mb;case 35669:case 35673:return wb;case 5125:return Eb;case 36294:return Ab;case 36295:return Tb;case 36296:return Cb;case 35678:case 36198:case 36298:case 36306:case 35682:return Rb;case 35679:case 36299:case 36307:return Pb;case 35680:case 36300:case 36308:case 36293:return Ib;case 36289:case 36303:case 36311:case 36292:return Lb}}var lu=class{constructor(t,e,n){this.id=t,this.addr=n,this.cache=[],this.type=e.type,this.setValue=fb(e.type)}},cu=class{constructor(t,e,n){this.id=t,this.addr=n,this.cache=[],this.type=e.type,this.size=e.size,this.setValue=Db(e.type)}},hu=class{constructor(t){this.id=t,this.seq=[],this.map={}}setValue(t,e,n){let s=this.seq;for(let r=0,o=s.length;r!==o;++r){let a=s[r];a.setValue(t,e[a.id],n)}}},ou=/(\w+)(\])?(\[|\.)?/g;function vp(i,t){i.seq.push(t),i.map[t.id]=t}function Nb(i,t,e){let n=i.name,s=n.length;for(ou.lastIndex=0;;){let r=ou.exec(n),o=ou.lastIndex,a=r[1],l=r[2]==="]",c=r[3];if(l&&(a=a|0),c===void 0||c==="["&&o+2===s){vp(e,c===void 0?new lu(a,i,t):new cu(a,i,t));break}else{let d=e.map[a];d===void 0&&(d=new hu(a),vp(e,d)),e=d}}}var Ws=class{constructor(t,e){this.seq=[],this.map={};let n=t.getProgramParameter(e,t.ACTIVE_UNIFORMS);for(let o=0;o<n;++o){let a=t.getActiveUniform(e,o),l=t.getUniformLocation(e,a.name);Nb(a,l,this)}let s=[],r=[];for(let o of this.seq)o.type===t.SAMPLER_2D_SHADOW||o.type===t.SAMPLER_CUBE_SHADOW||o.type===t.SAMPLER_2D_ARRAY_SHADOW?s.push(o):r.push(o);s.length>0&&(this.seq=s.concat(r))}setValue(t,e,n,s){let r=this.map[e];r!==void 0&&r.setValue(t,n,s)}setOptional(t,e,n){let s=e[n];s!==void 0&&this.setValue(t,n,s)}static upload(t,e,n,s){for(let r=0,o=e.length;r!==o;++r){let a=e[r],l=n[a.id];l.needsUpdate!==!1&&a.setValue(t,l.value,s)}}static seqWithValue(t,e){let n=[];for(let s=0,r=t.length;s!==r;++s){let o=t[s];o.id in e&&n.push(o)}return n}};function xp(i,t,e){let n=i.createShader(t);return i.shaderSource(n,e),i.compileShader(n),n}var Ub=37297,Fb=0;function Ob(i,t){let e=i.split(`
`),n=[],s=Math.max(t-6,0),r=Math.min(t+6,e.length);for(let o=s;o<r;o++){let a=o+1;n.push(`${a===t?">":" "} ${a}: ${e[o]}`)}return n.join(`
`)}var _p=new Nt;function Bb(i){Xt._getMatrix(_p,Xt.workingColorSpace,i);let t=`mat3( ${_p.elements.map(e=>e.toFixed(4))} )`;switch(Xt.getTransfer(i)){case gr:return[t,"LinearTransferOETF"];case Jt:return[t,"sRGBTransferOETF"];default:return Tt("WebGLProgram: Unsupported color space: ",i),[t,"LinearTransferOETF"]}}function yp(i,t,e){let n=i.getShaderParameter(t,i.COMPILE_STATUS),r=(i.getShaderInfoLog(t)||"").trim();if(n&&r==="")return"";let o=/ERROR: 0:(\d+)/.exec(r);if(o){let a=parseInt(o[1]);return e.toUpperCase()+`

`+r+`

`+Ob(i.getShaderSource(t),a)}else return r}function kb(i,t){let e=Bb(t);return[`vec4 ${i}( vec4 value ) {`,`	return ${e[1]}( vec4( ${e[0]} * value.rgb, value.a ) );`,"}"].join(`
`)}var zb={[Ch]:"Linear",[Rh]:"Reinhard",[Ph]:"Cineon",[Ih]:"ACESFilmic",[Dh]:"AgX",[Nh]:"Neutral",[Lh]:"Custom"};function Hb(i,t){let e=zb[t];return e===void 0?(Tt("WebGLProgram: Unsupported toneMapping:",t),"vec3 "+i+"( vec3 color ) { return LinearToneMapping( color ); }"):"vec3 "+i+"( vec3 color ) { return "+e+"ToneMapping( color ); }"}var yl=new P;function Gb(){Xt.getLuminanceCoefficients(yl);let i=yl.x.toFixed(4),t=yl.y.toFixed(4),e=yl.z.toFixed(4);return["float luminance( const in vec3 rgb ) {",`	const vec3 weights = vec3( ${i}, ${t}, ${e} );`,"	return dot( weights, rgb );","}"].join(`
`)}function Vb(i){return[i.extensionClipCullDistance?"#extension GL_ANGLE_clip_cull_distance : require":"",i.extensionMultiDraw?"#extension GL_ANGLE_multi_draw : require":""].filter(jr).join(`
`)}function Wb(i){let t=[];for(let e in i){let n=i[e];n!==!1&&t.push("#define "+e+" "+n)}return t.join(`
`)}function $b(i,t){let e={},n=i.getProgramParameter(t,i.ACTIVE_ATTRIBUTES);for(let s=0;s<n;s++){let r=i.getActiveAttrib(t,s),o=r.name,a=1;r.type===i.FLOAT_MAT2&&(a=2),r.type===i.FLOAT_MAT3&&(a=3),r.type===i.FLOAT_MAT4&&(a=4),e[o]={type:r.type,location:i.getAttribLocation(t,o),locationSize:a}}return e}function jr(i){return i!==""}function bp(i,t){let e=t.numSpotLightShadows+t.numSpotLightMaps-t.numSpotLightShadowsWithMaps;return i.replace(/NUM_SUN_LIGHTS/g,t.numSunLights).replace(/NUM_DIR_LIGHTS/g,t.numDirLights).replace(/NUM_SPOT_LIGHTS/g,t.numSpotLights).replace(/NUM_SPOT_LIGHT_MAPS/g,t.numSpotLightMaps).replace(/NUM_SPOT_LIGHT_COORDS/g,e).replace(/NUM_RECT_AREA_LIGHTS/g,t.numRectAreaLights).replace(/NUM_POINT_LIGHTS/g,t.numPointLights).replace(/NUM_HEMI_LIGHTS/g,t.numHemiLights).replace(/NUM_SUN_LIGHT_SHADOWS/g,t.numSunLightShadows).replace(/NUM_DIR_LIGHT_SHADOWS/g,t.numDirLightShadows).replace(/NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS/g,t.numSpotLightShadowsWithMaps).replace(/NUM_SPOT_LIGHT_SHADOWS/g,t.numSpotLightShadows).replace(/NUM_POINT_LIGHT_SHADOWS/g,t.numPointLightShadows).replace(/NUM_LIGHT_PROBE_GRIDS/g,t.numLightProbeGrids)}function Sp(i,t){return i.replace(/NUM_CLIPPING_PLANES/g,t.numClippingPlanes).replace(/UNION_CLIPPING_PLANES/g,t.numClippingPlanes-t.numClipIntersection)}var Xb=/^[ \t]*#include +<([\w\d./]+)>/gm;function uu(i){return i.replace(Xb,qb)}function qb(i,t){let e=Ht[t];if(e===void 0)throw new Error("THREE.WebGLProgram: Can not resolve #include <"+t+">");return uu(e)}var Yb=/#pragma unroll_loop_start\s+for\s*\(\s*int\s+i\s*=\s*(\d+)\s*;\s*i\s*<\s*(\d+)\s*;\s*i\s*\+\+\s*\)\s*{([\s\S]+?)}\s+#pragma unroll_loop_end/g;function Mp(i){return i.replace(Yb,jb)}function jb(i,t,e,n){let s="";for(let r=parseInt(t);r<parseInt(e);r++)s+=n.replace(/\[\s*i\s*\]/g,"[ "+r+" ]").replace(/UNROLLED_LOOP_INDEX/g,r);return s}function wp(i){let t=`precision ${i.precision} float;
	precision ${i.precision} int;
	precision ${i.precision} sampler2D;
	precision ${i.precision} samplerCube;
	precision ${i.precision} sampler3D;
	precision ${i.precision} sampler2DArray;
	precision ${i.precision} sampler2DShadow;
	precision ${i.precision} samplerCubeShadow;
	precision ${i.precision} sampler2DArrayShadow;
	precision ${i.precision} isampler2D;
	precision ${i.precision} isampler3D;
	precision ${i.precision} isamplerCube;
	precision ${i.precision} isampler2DArray;
	precision ${i.precision} usampler2D;
	precision ${i.precision} usampler3D;
	precision ${i.precision} usamplerCube;
	precision ${i.precision} usampler2DArray;
	`;return i.precision==="highp"?t+=`
#define HIGH_PRECISION`:i.precision==="mediump"?t+=`
#define MEDIUM_PRECISION`:i.precision==="lowp"&&(t+=`
#define LOW_PRECISION`),t}var Zb={[kr]:"SHADOWMAP_TYPE_PCF",[zs]:"SHADOWMAP_TYPE_VSM"};function Kb(i){return Zb[i.shadowMapType]||"SHADOWMAP_TYPE_BASIC"}var Jb={[Gs]:"ENVMAP_MODE_REFRACTION"};function Qb(i){return i.envMap===!1?"ENVMAP_MODE_REFLECTION":Jb[i.envMapMode]||"ENVMAP_MODE_REFLECTION"}var tS={[Th]:"ENVMAP_BLENDING_MULTIPLY",[zf]:"ENVMAP_BLENDING_MIX",[Hf]:"ENVMAP_BLENDING_ADD"};function eS(i){return i.envMap===!1?"ENVMAP_BLENDING_NONE":tS[i.combine]||"ENVMAP_BLENDING_NONE"}function nS(i,t,e,n){let s=i.getContext(),r=e.defines,o=e.vertexShader,a=e.fragmentShader,l=Kb(e),c=e.envMapPMREM===!0?"ENVMAP_TYPE_PMREM":"ENVMAP_TYPE_CUBE",h=Qb(e),d=eS(e),u=Vb(e),f=Wb(r),g=s.createProgram(),x,p,m=e.glslVersion?"#version "+e.glslVersion+`
`:"";e.isRawShaderMaterial?(x=["#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,f].filter(jr).join(`
`),x.length>0&&(x+=`
`),p=["#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,f].filter(jr).join(`
`),p.length>0&&(p+=`
`)):(x=[wp(e),"#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,f,e.extensionClipCullDistance?"#define USE_CLIP_DISTANCE":"",e.batching?"#define USE_BATCHING":"",e.batchingColor?"#define USE_BATCHING_COLOR":"",e.instancing?"#define USE_INSTANCING":"",e.instancingColor?"#define USE_INSTANCING_COLOR":"",e.instancingMorph?"#define USE_INSTANCING_MORPH":"",e.useFog&&e.fog?"#define USE_FOG":"",e.useFog&&e.fogExp2?"#define FOG_EXP2":"",e.map?"#define USE_MAP":"",e.envMap?"#define USE_ENVMAP":"",e.envMap?"#define "+h:"",e.lightMap?"#define USE_LIGHTMAP":"",e.aoMap?"#define USE_AOMAP":"",e.bumpMap?"#define USE_BUMPMAP":"",e.normalMap?"#define USE_NORMALMAP":"",e.normalMapObjectSpace?"#define USE_NORMALMAP_OBJECTSPACE":"",e.normalMapTangentSpace?"#define USE_NORMALMAP_TANGENTSPACE":"",e.displacementMap?"#define USE_DISPLACEMENTMAP":"",e.emissiveMap?"#define USE_EMISSIVEMAP":"",e.anisotropy?"#define USE_ANISOTROPY":"",e.anisotropyMap?"#define USE_ANISOTROPYMAP":"",e.clearcoatMap?"#define USE_CLEARCOATMAP":"",e.clearcoatRoughnessMap?"#define USE_CLEARCOAT_ROUGHNESSMAP":"",e.clearcoatNormalMap?"#define USE_CLEARCOAT_NORMALMAP":"",e.diffuseRoughnessMap?"#define USE_DIFFUSE_ROUGHNESSMAP":"",e.iridescenceMap?"#define USE_IRIDESCENCEMAP":"",e.iridescenceThicknessMap?"#define USE_IRIDESCENCE_THICKNESSMAP":"",e.specularMap?"#define USE_SPECULARMAP":"",e.specularColorMap?"#define USE_SPECULAR_COLORMAP":"",e.specularIntensityMap?"#define USE_SPECULAR_INTENSITYMAP":"",e.roughnessMap?"#define USE_ROUGHNESSMAP":"",e.metalnessMap?"#define USE_METALNESSMAP":"",e.alphaMap?"#define USE_ALPHAMAP":"",e.alphaHash?"#define USE_ALPHAHASH":"",e.transmission?"#define USE_TRANSMISSION":"",e.transmissionMap?"#define USE_TRANSMISSIONMAP":"",e.thicknessMap?"#define USE_THICKNESSMAP":"",e.sheenColorMap?"#define USE_SHEEN_COLORMAP":"",e.sheenRoughnessMap?"#define USE_SHEEN_ROUGHNESSMAP":"",e.mapUv?"#define MAP_UV "+e.mapUv:"",e.alphaMapUv?"#define ALPHAMAP_UV "+e.alphaMapUv:"",e.lightMapUv?"#define LIGHTMAP_UV "+e.lightMapUv:"",e.aoMapUv?"#define AOMAP_UV "+e.aoMapUv:"",e.emissiveMapUv?"#define EMISSIVEMAP_UV "+e.emissiveMapUv:"",e.bumpMapUv?"#define BUMPMAP_UV "+e.bumpMapUv:"",e.normalMapUv?"#define NORMALMAP_UV "+e.normalMapUv:"",e.displacementMapUv?"#define DISPLACEMENTMAP_UV "+e.displacementMapUv:"",e.metalnessMapUv?"#define METALNESSMAP_UV "+e.metalnessMapUv:"",e.roughnessMapUv?"#define ROUGHNESSMAP_UV "+e.roughnessMapUv:"",e.anisotropyMapUv?"#define ANISOTROPYMAP_UV "+e.anisotropyMapUv:"",e.clearcoatMapUv?"#define CLEARCOATMAP_UV "+e.clearcoatMapUv:"",e.clearcoatNormalMapUv?"#define CLEARCOAT_NORMALMAP_UV "+e.clearcoatNormalMapUv:"",e.clearcoatRoughnessMapUv?"#define CLEARCOAT_ROUGHNESSMAP_UV "+e.clearcoatRoughnessMapUv:"",e.diffuseRoughnessMapUv?"#define DIFFUSE_ROUGHNESSMAP_UV "+e.diffuseRoughnessMapUv:"",e.iridescenceMapUv?"#define IRIDESCENCEMAP_UV "+e.iridescenceMapUv:"",e.iridescenceThicknessMapUv?"#define IRIDESCENCE_THICKNESSMAP_UV "+e.iridescenceThicknessMapUv:"",e.sheenColorMapUv?"#define SHEEN_COLORMAP_UV "+e.sheenColorMapUv:"",e.sheenRoughnessMapUv?"#define SHEEN_ROUGHNESSMAP_UV "+e.sheenRoughnessMapUv:"",e.specularMapUv?"#define SPECULARMAP_UV "+e.specularMapUv:"",e.specularColorMapUv?"#define SPECULAR_COLORMAP_UV "+e.specularColorMapUv:"",e.specularIntensityMapUv?"#define SPECULAR_INTENSITYMAP_UV "+e.specularIntensityMapUv:"",e.transmissionMapUv?"#define TRANSMISSIONMAP_UV "+e.transmissionMapUv:"",e.thicknessMapUv?"#define THICKNESSMAP_UV "+e.thicknessMapUv:"",e.vertexTangents&&e.flatShading===!1?"#define USE_TANGENT":"",e.vertexNormals?"#define HAS_NORMAL":"",e.vertexColors?"#define USE_COLOR":"",e.vertexAlphas?"#define USE_COLOR_ALPHA":"",e.vertexUv1s?"#define USE_UV1":"",e.vertexUv2s?"#define USE_UV2":"",e.vertexUv3s?"#define USE_UV3":"",e.pointsUvs?"#define USE_POINTS_UV":"",e.flatShading?"#define FLAT_SHADED":"",e.skinning?"#define USE_SKINNING":"",e.morphTargets?"#define USE_MORPHTARGETS":"",e.morphNormals&&e.flatShading===!1?"#define USE_MORPHNORMALS":"",e.morphColors?"#define USE_MORPHCOLORS":"",e.morphTargetsCount>0?"#define MORPHTARGETS_TEXTURE_STRIDE "+e.morphTextureStride:"",e.morphTargetsCount>0?"#define MORPHTARGETS_COUNT "+e.morphTargetsCount:"",e.doubleSided?"#define DOUBLE_SIDED":"",e.flipSided?"#define FLIP_SIDED":"",e.shadowMapEnabled?"#define USE_SHADOWMAP":"",e.shadowMapEnabled?"#define "+l:"",e.sizeAttenuation?"#define USE_SIZEATTENUATION":"",e.numLightProbes>0?"#define USE_LIGHT_PROBES":"",e.logarithmicDepthBuffer?"#define USE_LOGARITHMIC_DEPTH_BUFFER":"",e.reversedDepthBuffer?"#define USE_REVERSED_DEPTH_BUFFER":"","uniform mat4 modelMatrix;","uniform mat4 modelViewMatrix;","uniform mat4 projectionMatrix;","uniform mat4 viewMatrix;","uniform mat3 normalMatrix;","uniform vec3 cameraPosition;","uniform bool isOrthographic;","#ifdef USE_INSTANCING","	attribute mat4 instanceMatrix;","#endif","#ifdef USE_INSTANCING_COLOR","	attribute vec3 instanceColor;","#endif","#ifdef USE_INSTANCING_MORPH","	uniform sampler2D morphTexture;","#endif","attribute vec3 position;","attribute vec3 normal;","attribute vec2 uv;","#ifdef USE_UV1","	attribute vec2 uv1;","#endif","#ifdef USE_UV2","	attribute vec2 uv2;","#endif","#ifdef USE_UV3","	attribute vec2 uv3;","#endif","#ifdef USE_TANGENT","	attribute vec4 tangent;","#endif","#if defined( USE_COLOR_ALPHA )","	attribute vec4 color;","#elif defined( USE_COLOR )","	attribute vec3 color;","#endif","#ifdef USE_SKINNING","	attribute vec4 skinIndex;","	attribute vec4 skinWeight;","#endif",`
`].filter(jr).join(`
`),p=[wp(e),"#define SHADER_TYPE "+e.shaderType,"#define SHADER_NAME "+e.shaderName,f,e.useFog&&e.fog?"#define USE_FOG":"",e.useFog&&e.fogExp2?"#define FOG_EXP2":"",e.alphaToCoverage?"#define ALPHA_TO_COVERAGE":"",e.map?"#define USE_MAP":"",e.matcap?"#define USE_MATCAP":"",e.envMap?"#define USE_ENVMAP":"",e.envMap?"#define "+c:"",e.envMap?"#define "+h:"",e.envMap?"#define "+d:"",e.envMapPMREM?"#define ENVMAP_MAX_LOD "+e.envMapMaxLod+".0":"",e.envMapPMREM?"#define ENVMAP_SIZE "+e.envMapSize+".0":"",e.lightMap?"#define USE_LIGHTMAP":"",e.aoMap?"#define USE_AOMAP":"",e.bumpMap?"#define USE_BUMPMAP":"",e.normalMap?"#define USE_NORMALMAP":"",e.normalMapObjectSpace?"#define USE_NORMALMAP_OBJECTSPACE":"",e.normalMapTangentSpace?"#define USE_NORMALMAP_TANGENTSPACE":"",e.packedNormalMap?"#define USE_PACKED_NORMALMAP":"",e.emissiveMap?"#define USE_EMISSIVEMAP":"",e.anisotropy?"#define USE_ANISOTROPY":"",e.anisotropyMap?"#define USE_ANISOTROPYMAP":"",e.clearcoat?"#define USE_CLEARCOAT":"",e.clearcoatMap?"#define USE_CLEARCOATMAP":"",e.clearcoatRoughnessMap?"#define USE_CLEARCOAT_ROUGHNESSMAP":"",e.clearcoatNormalMap?"#define USE_CLEARCOAT_NORMALMAP":"",e.diffuseRoughness?"#define USE_DIFFUSE_ROUGHNESS":"",e.diffuseRoughnessMap?"#define USE_DIFFUSE_ROUGHNESSMAP":"",e.dispersion?"#define USE_DISPERSION":"",e.retroreflection?"#define USE_RETROREFLECTION":"",e.iridescence?"#define USE_IRIDESCENCE":"",e.iridescenceMap?"#define USE_IRIDESCENCEMAP":"",e.iridescenceThicknessMap?"#define USE_IRIDESCENCE_THICKNESSMAP":"",e.specularMap?"#define USE_SPECULARMAP":"",e.specularColorMap?"#define USE_SPECULAR_COLORMAP":"",e.specularIntensityMap?"#define USE_SPECULAR_INTENSITYMAP":"",e.roughnessMap?"#define USE_ROUGHNESSMAP":"",e.metalnessMap?"#define USE_METALNESSMAP":"",e.alphaMap?"#define USE_ALPHAMAP":"",e.alphaTest?"#define USE_ALPHATEST":"",e.alphaHash?"#define USE_ALPHAHASH":"",e.sheen?"#define USE_SHEEN":"",e.sheenColorMap?"#define USE_SHEEN_COLORMAP":"",e.sheenRoughnessMap?"#define USE_SHEEN_ROUGHNESSMAP":"",e.transmission?"#define USE_TRANSMISSION":"",e.transmissionMap?"#define USE_TRANSMISSIONMAP":"",e.thicknessMap?"#define USE_THICKNESSMAP":"",e.vertexTangents&&e.flatShading===!1?"#define USE_TANGENT":"",e.vertexColors||e.instancingColor?"#define USE_COLOR":"",e.vertexAlphas||e.batchingColor?"#define USE_COLOR_ALPHA":"",e.vertexUv1s?"#define USE_UV1":"",e.vertexUv2s?"#define USE_UV2":"",e.vertexUv3s?"#define USE_UV3":"",e.pointsUvs?"#define USE_POINTS_UV":"",e.gradientMap?"#define USE_GRADIENTMAP":"",e.flatShading?"#define FLAT_SHADED":"",e.doubleSided?"#define DOUBLE_SIDED":"",e.flipSided?"#define FLIP_SIDED":"",e.shadowMapEnabled?"#define USE_SHADOWMAP":"",e.shadowMapEnabled?"#define "+l:"",e.premultipliedAlpha?"#define PREMULTIPLIED_ALPHA":"",e.numLightProbes>0?"#define USE_LIGHT_PROBES":"",e.decodeVideoTexture?"#define DECODE_VIDEO_TEXTURE":"",e.decodeVideoTextureEmissive?"#define DECODE_VIDEO_TEXTURE_EMISSIVE":"",e.logarithmicDepthBuffer?"#define USE_LOGARITHMIC_DEPTH_BUFFER":"",e.reversedDepthBuffer?"#define USE_REVERSED_DEPTH_BUFFER":"","uniform mat4 viewMatrix;","uniform vec3 cameraPosition;","uniform bool isOrthographic;",e.toneMapping!==Zn?"#define TONE_MAPPING":"",e.toneMapping!==Zn?Ht.tonemapping_pars_fragment:"",e.toneMapping!==Zn?Hb("toneMapping",e.toneMapping):"",e.dithering?"#define DITHERING":"",e.opaque?"#define OPAQUE":"",Ht.colorspace_pars_fragment,kb("linearToOutputTexel",e.outputColorSpace),Gb(),e.useDepthPacking?"#define DEPTH_PACKING "+e.depthPacking:"",`
`].filter(jr).join(`
`)),o=uu(o),o=bp(o,e),o=Sp(o,e),a=uu(a),a=bp(a,e),a=Sp(a,e),o=Mp(o),a=Mp(a),e.isRawShaderMaterial!==!0&&(m=`#version 300 es
`,x=[u,"#define attribute in","#define varying out","#define texture2D texture"].join(`
`)+`
`+x,p=["#define varying in",e.glslVersion===Kh?"":"layout(location = 0) out highp vec4 pc_fragColor;",e.glslVersion===Kh?"":"#define gl_FragColor pc_fragColor","#define gl_FragDepthEXT gl_FragDepth","#define texture2D texture","#define textureCube texture","#define texture2DProj textureProj","#define texture2DLodEXT textureLod","#define texture2DProjLodEXT textureProjLod","#define textureCubeLodEXT textureLod","#define texture2DGradEXT textureGrad","#define texture2DProjGradEXT textureProjGrad","#define textureCubeGradEXT textureGrad"].join(`
`)+`
`+p);let _=m+x+o,M=m+p+a,y=xp(s,s.VERTEX_SHADER,_),T=xp(s,s.FRAGMENT_SHADER,M);s.attachShader(g,y),s.attachShader(g,T),e.index0AttributeName!==void 0?s.bindAttribLocation(g,0,e.index0AttributeName):e.hasPositionAttribute===!0&&s.bindAttribLocation(g,0,"position"),s.linkProgram(g);function E(D){if(i.debug.checkShaderErrors){let N=s.getProgramInfoLog(g)||"",O=s.getShaderInfoLog(y)||"",V=s.getShaderInfoLog(T)||"",C=N.trim(),H=O.trim(),X=V.trim(),G=!0,nt=!0;if(s.getProgramParameter(g,s.LINK_STATUS)===!1)if(G=!1,typeof i.debug.onShaderError=="function")i.debug.onShaderError(s,g,y,T);else{let $=yp(s,y,"vertex"),Q=yp(s,T,"fragment");Lt("WebGLProgram: Shader Error "+s.getError()+" - VALIDATE_STATUS "+s.getProgramParameter(g,s.VALIDATE_STATUS)+`

Material Name: `+D.name+`
Material Type: `+D.type+`

Program Info Log: `+C+`
`+$+`
`+Q)}else C!==""?Tt("WebGLProgram: Program Info Log:",C):(H===""||X==="")&&(nt=!1);nt&&(D.diagnostics={runnable:G,programLog:C,vertexShader:{log:H,prefix:x},fragmentShader:{log:X,prefix:p}})}s.deleteShader(y),s.deleteShader(T),v=new Ws(s,g),w=$b(s,g)}let v;this.getUniforms=function(){return v===void 0&&E(this),v};let w;this.getAttributes=function(){return w===void 0&&E(this),w};let F=e.rendererExtensionParallelShaderCompile===!1;return this.isReady=function(){return F===!1&&(F=s.getProgramParameter(g,Ub)),F},this.destroy=function(){n.releaseStatesOfProgram(this),s.deleteProgram(g),this.program=void 0},this.type=e.shaderType,this.name=e.shaderName,this.id=Fb++,this.cacheKey=t,this.usedTimes=1,this.program=g,this.vertexShader=y,this.fragmentShader=T,this}var iS=0,du=class{constructor(){this.shaderCache=new Map,this.materialCache=new Map}update(t,e,n){let s=this._getShaderCacheForMaterial(t);return s.has(e)===!1&&(s.add(e),e.usedTimes++),s.has(n)===!1&&(s.add(n),n.usedTimes++),this}remove(t){let e=this.materialCache.get(t);for(let n of e)n.usedTimes--,n.usedTimes===0&&this.shaderCache.delete(n.code);return this.materialCache.delete(t),this}getVertexShaderStage(t){return this._getShaderStage(t.vertexShader)}getFragmentShaderStage(t){return this._getShaderStage(t.fragmentShader)}dispose(){this.shaderCache.clear(),this.materialCache.clear()}_getShaderCacheForMaterial(t){let e=this.materialCache,n=e.get(t);return n===void 0&&(n=new Set,e.set(t,n)),n}_getShaderStage(t){let e=this.shaderCache,n=e.get(t);return n===void 0&&(n=new fu(t),e.set(t,n)),n}},fu=class{constructor(t){this.id=iS++,this.code=t,this.usedTimes=0}};function sS(i){return i===zi||i===$r||i===Xr}function rS(i,t,e,n,s,r){let o=new Ls,a=new du,l=new Set,c=[],h=new Map,d=n.logarithmicDepthBuffer,u={MeshDepthMaterial:"depth",MeshDistanceMaterial:"distance",MeshNormalMaterial:"normal",MeshBasicMaterial:"basic",MeshLambertMaterial:"lambert",MeshPhongMaterial:"phong",MeshToonMaterial:"toon",MeshStandardMaterial:"physical",MeshPhysicalMaterial:"physical",MeshMatcapMaterial:"matcap",LineBasicMaterial:"basic",LineDashedMaterial:"dashed",PointsMaterial:"points",ShadowMaterial:"shadow",SpriteMaterial:"sprite"};function f(v){return l.add(v),v===0?"uv":`uv${v}`}function g(v,w,F,D,N,O){let V=D.fog,C=N.geometry,H=v.isMeshStandardMaterial||v.isMeshLambertMaterial||v.isMeshPhongMaterial?D.environment:null,X=v.isMeshStandardMaterial||v.isMeshLambertMaterial&&!v.envMap||v.isMeshPhongMaterial&&!v.envMap,G=t.get(v.envMap||H,X),nt=u[v.type],$=n.precision;v.precision!==null&&($=n.getMaxPrecision(v.precision),$!==v.precision&&Tt("WebGLProgram.getParameters:",v.precision,"not supported, using",$,"instead."));let Q=C.morphAttributes.position||C.morphAttributes.normal||C.morphAttributes.color,et=Q!==void 0?Q.length:0,yt=0;C.morphAttributes.position!==void 0&&(yt=1),C.morphAttributes.normal!==void 0&&(yt=2),C.morphAttributes.color!==void 0&&(yt=3);let Dt,Z,gt,bt;if(nt){let mt=nn[nt];Dt=mt.vertexShader,Z=mt.fragmentShader}else{Dt=v.vertexShader,Z=v.fragmentShader;let mt=a.getVertexShaderStage(v),ee=a.getFragmentShaderStage(v);a.update(v,mt,ee),gt=mt.id,bt=ee.id}let Rt=i.getRenderTarget(),vt=i.state.buffers.depth.getReversed(),Bt=N.isInstancedMesh===!0,xe=N.isBatchedMesh===!0,It=!!v.map,te=!!v.matcap,ie=!!G,Vt=ie&&G.isPMREMTexture===!0,Fe=!!v.aoMap,Me=!!v.lightMap,rn=!!v.bumpMap&&v.wireframe===!1,de=!!v.normalMap,qn=!!v.displacementMap,Pe=!!v.emissiveMap,Sn=!!v.metalnessMap,Mn=!!v.roughnessMap,wn=v.anisotropy>0,U=v.clearcoat>0,En=v.diffuseRoughness>0,le=v.dispersion>0,ce=v.retroreflectivity>0,pt=v.iridescence>0,we=v.sheen>0,Pt=v.transmission>0,Ut=wn&&!!v.anisotropyMap,A=U&&!!v.clearcoatMap,b=U&&!!v.clearcoatNormalMap,k=U&&!!v.clearcoatRoughnessMap,it=En&&!!v.diffuseRoughnessMap,J=pt&&!!v.iridescenceMap,ot=pt&&!!v.iridescenceThicknessMap,ut=we&&!!v.sheenColorMap,Y=we&&!!v.sheenRoughnessMap,j=!!v.specularMap,lt=!!v.specularColorMap,R=!!v.specularIntensityMap,K=Pt&&!!v.transmissionMap,q=Pt&&!!v.thicknessMap,ct=!!v.gradientMap,rt=!!v.alphaMap,at=v.alphaTest>0,Et=!!v.alphaHash,zt=!!v.extensions,st=Zn;v.toneMapped&&(Rt===null||Rt.isXRRenderTarget===!0)&&(st=i.toneMapping);let At=Vt?G.isCompressedCubeTexture?G.image[0].mipmaps:G.mipmaps:null,kt={shaderID:nt,shaderType:v.type,shaderName:v.name,vertexShader:Dt,fragmentShader:Z,defines:v.defines,customVertexShaderID:gt,customFragmentShaderID:bt,isRawShaderMaterial:v.isRawShaderMaterial===!0,glslVersion:v.glslVersion,precision:$,batching:xe,batchingColor:xe&&N._colorsTexture!==null,instancing:Bt,instancingColor:Bt&&N.instanceColor!==null,instancingMorph:Bt&&N.morphTexture!==null,outputColorSpace:Rt===null?i.outputColorSpace:Rt.isXRRenderTarget===!0?Rt.texture.colorSpace:Xt.workingColorSpace,alphaToCoverage:!!v.alphaToCoverage,map:It,matcap:te,envMap:ie,envMapMode:ie&&G.mapping,envMapPMREM:Vt,envMapMaxLod:Vt?At.length-1:null,envMapSize:Vt?At[0].width:null,aoMap:Fe,lightMap:Me,bumpMap:rn,normalMap:de,displacementMap:qn,emissiveMap:Pe,normalMapObjectSpace:de&&v.normalMapType===Wf,normalMapTangentSpace:de&&v.normalMapType===Vh,packedNormalMap:de&&v.normalMapType===Vh&&sS(v.normalMap.format),metalnessMap:Sn,roughnessMap:Mn,anisotropy:wn,anisotropyMap:Ut,clearcoat:U,clearcoatMap:A,clearcoatNormalMap:b,clearcoatRoughnessMap:k,diffuseRoughness:En,diffuseRoughnessMap:it,dispersion:le,retroreflection:ce,iridescence:pt,iridescenceMap:J,iridescenceThicknessMap:ot,sheen:we,sheenColorMap:ut,sheenRoughnessMap:Y,specularMap:j,specularColorMap:lt,specularIntensityMap:R,transmission:Pt,transmissionMap:K,thicknessMap:q,gradientMap:ct,opaque:v.transparent===!1&&v.blending===Hs&&v.alphaToCoverage===!1,alphaMap:rt,alphaTest:at,alphaHash:Et,combine:v.combine,mapUv:It&&f(v.map.channel),aoMapUv:Fe&&f(v.aoMap.channel),lightMapUv:Me&&f(v.lightMap.channel),bumpMapUv:rn&&f(v.bumpMap.channel),normalMapUv:de&&f(v.normalMap.channel),displacementMapUv:qn&&f(v.displacementMap.channel),emissiveMapUv:Pe&&f(v.emissiveMap.channel),metalnessMapUv:Sn&&f(v.metalnessMap.channel),roughnessMapUv:Mn&&f(v.roughnessMap.channel),anisotropyMapUv:Ut&&f(v.anisotropyMap.channel),clearcoatMapUv:A&&f(v.clearcoatMap.channel),clearcoatNormalMapUv:b&&f(v.clearcoatNormalMap.channel),clearcoatRoughnessMapUv:k&&f(v.clearcoatRoughnessMap.channel),diffuseRoughnessMapUv:it&&f(v.diffuseRoughnessMap.channel),iridescenceMapUv:J&&f(v.iridescenceMap.channel),iridescenceThicknessMapUv:ot&&f(v.iridescenceThicknessMap.channel),sheenColorMapUv:ut&&f(v.sheenColorMap.channel),sheenRoughnessMapUv:Y&&f(v.sheenRoughnessMap.channel),specularMapUv:j&&f(v.specularMap.channel),specularColorMapUv:lt&&f(v.specularColorMap.channel),specularIntensityMapUv:R&&f(v.specularIntensityMap.channel),transmissionMapUv:K&&f(v.transmissionMap.channel),thicknessMapUv:q&&f(v.thicknessMap.channel),alphaMapUv:rt&&f(v.alphaMap.channel),vertexTangents:!!C.attributes.tangent&&(de||wn),vertexNormals:!!C.attributes.normal,vertexColors:v.vertexColors,vertexAlphas:v.vertexColors===!0&&!!C.attributes.color&&C.attributes.color.itemSize===4,pointsUvs:N.isPoints===!0&&!!C.attributes.uv&&(It||rt),fog:!!V,useFog:v.fog===!0,fogExp2:!!V&&V.isFogExp2,flatShading:v.wireframe===!1&&(v.flatShading===!0||C.attributes.normal===void 0&&de===!1&&(v.isMeshLambertMaterial||v.isMeshPhongMaterial||v.isMeshStandardMaterial||v.isMeshPhysicalMaterial)),sizeAttenuation:v.sizeAttenuation===!0,logarithmicDepthBuffer:d,reversedDepthBuffer:vt,skinning:N.isSkinnedMesh===!0,hasPositionAttribute:C.attributes.position!==void 0,morphTargets:C.morphAttributes.position!==void 0,morphNormals:C.morphAttributes.normal!==void 0,morphColors:C.morphAttributes.color!==void 0,morphTargetsCount:et,morphTextureStride:yt,numSunLights:w.sun.length,numDirLights:w.directional.length,numPointLights:w.point.length,numSpotLights:w.spot.length,numSpotLightMaps:w.spotLightMap.length,numRectAreaLights:w.rectArea.length,numHemiLights:w.hemi.length,numSunLightShadows:w.sunShadowMap.length,numDirLightShadows:w.directionalShadowMap.length,numPointLightShadows:w.pointShadowMap.length,numSpotLightShadows:w.spotShadowMap.length,numSpotLightShadowsWithMaps:w.numSpotLightShadowsWithMaps,numLightProbes:w.numLightProbes,numLightProbeGrids:O.filter(mt=>mt.texture!==null).length,numClippingPlanes:r.numPlanes,numClipIntersection:r.numIntersection,dithering:v.dithering,shadowMapEnabled:i.shadowMap.enabled&&F.length>0,shadowMapType:i.shadowMap.type,toneMapping:st,decodeVideoTexture:It&&v.map.isVideoTexture===!0&&Xt.getTransfer(v.map.colorSpace)===Jt,decodeVideoTextureEmissive:Pe&&v.emissiveMap.isVideoTexture===!0&&Xt.getTransfer(v.emissiveMap.colorSpace)===Jt,premultipliedAlpha:v.premultipliedAlpha,doubleSided:v.side===en,flipSided:v.side===Ae,useDepthPacking:v.depthPacking>=0,depthPacking:v.depthPacking||0,index0AttributeName:v.index0AttributeName,extensionClipCullDistance:zt&&v.extensions.clipCullDistance===!0&&e.has("WEBGL_clip_cull_distance"),extensionMultiDraw:(zt&&v.extensions.multiDraw===!0||xe)&&e.has("WEBGL_multi_draw"),rendererExtensionParallelShaderCompile:e.has("KHR_parallel_shader_compile"),customProgramCacheKey:v.customProgramCacheKey()};return kt.vertexUv1s=l.has(1),kt.vertexUv2s=l.has(2),kt.vertexUv3s=l.has(3),l.clear(),kt}function x(v){let w=[];if(v.shaderID?w.push(v.shaderID):(w.push(v.customVertexShaderID),w.push(v.customFragmentShaderID)),v.defines!==void 0)for(let F in v.defines)w.push(F),w.push(v.defines[F]);return v.isRawShaderMaterial===!1&&(p(w,v),m(w,v),w.push(i.outputColorSpace)),w.push(v.customProgramCacheKey),w.join()}function p(v,w){v.push(w.precision),v.push(w.outputColorSpace),v.push(w.envMapMode),v.push(w.envMapPMREM),v.push(w.envMapMaxLod),v.push(w.envMapSize),v.push(w.mapUv),v.push(w.alphaMapUv),v.push(w.lightMapUv),v.push(w.aoMapUv),v.push(w.bumpMapUv),v.push(w.normalMapUv),v.push(w.displacementMapUv),v.push(w.emissiveMapUv),v.push(w.metalnessMapUv),v.push(w.roughnessMapUv),v.push(w.anisotropyMapUv),v.push(w.clearcoatMapUv),v.push(w.clearcoatNormalMapUv),v.push(w.clearcoatRoughnessMapUv),v.push(w.diffuseRoughnessMapUv),v.push(w.iridescenceMapUv),v.push(w.iridescenceThicknessMapUv),v.push(w.sheenColorMapUv),v.push(w.sheenRoughnessMapUv),v.push(w.specularMapUv),v.push(w.specularColorMapUv),v.push(w.specularIntensityMapUv),v.push(w.transmissionMapUv),v.push(w.thicknessMapUv),v.push(w.combine),v.push(w.fogExp2),v.push(w.sizeAttenuation),v.push(w.morphTargetsCount),v.push(w.numSunLights),v.push(w.numDirLights),v.push(w.numPointLights),v.push(w.numSpotLights),v.push(w.numSpotLightMaps),v.push(w.numHemiLights),v.push(w.numRectAreaLights),v.push(w.numSunLightShadows),v.push(w.numDirLightShadows),v.push(w.numPointLightShadows),v.push(w.numSpotLightShadows),v.push(w.numSpotLightShadowsWithMaps),v.push(w.numLightProbes),v.push(w.numLightProbeGrids),v.push(w.shadowMapType),v.push(w.toneMapping),v.push(w.numClippingPlanes),v.push(w.numClipIntersection),v.push(w.depthPacking)}function m(v,w){o.disableAll(),w.instancing&&o.enable(0),w.instancingColor&&o.enable(1),w.instancingMorph&&o.enable(2),w.matcap&&o.enable(3),w.envMap&&o.enable(4),w.normalMapObjectSpace&&o.enable(5),w.normalMapTangentSpace&&o.enable(6),w.clearcoat&&o.enable(7),w.iridescence&&o.enable(8),w.alphaTest&&o.enable(9),w.vertexColors&&o.enable(10),w.vertexAlphas&&o.enable(11),w.vertexUv1s&&o.enable(12),w.vertexUv2s&&o.enable(13),w.vertexUv3s&&o.enable(14),w.vertexTangents&&o.enable(15),w.anisotropy&&o.enable(16),w.alphaHash&&o.enable(17),w.batching&&o.enable(18),w.dispersion&&o.enable(19),w.retroreflection&&o.enable(24),w.diffuseRoughness&&o.enable(25),w.batchingColor&&o.enable(20),w.gradientMap&&o.enable(21),w.packedNormalMap&&o.enable(22),w.vertexNormals&&o.enable(23),v.push(o.mask),o.disableAll(),w.fog&&o.enable(0),w.useFog&&o.enable(1),w.flatShading&&o.enable(2),w.logarithmicDepthBuffer&&o.enable(3),w.reversedDepthBuffer&&o.enable(4),w.skinning&&o.enable(5),w.morphTargets&&o.enable(6),w.morphNormals&&o.enable(7),w.morphColors&&o.enable(8),w.premultipliedAlpha&&o.enable(9),w.shadowMapEnabled&&o.enable(10),w.doubleSided&&o.enable(11),w.flipSided&&o.enable(12),w.useDepthPacking&&o.enable(13),w.dithering&&o.enable(14),w.transmission&&o.enable(15),w.sheen&&o.enable(16),w.opaque&&o.enable(17),w.pointsUvs&&o.enable(18),w.decodeVideoTexture&&o.enable(19),w.decodeVideoTextureEmissive&&o.enable(20),w.alphaToCoverage&&o.enable(21),w.numLightProbeGrids>0&&o.enable(22),w.hasPositionAttribute&&o.enable(23),v.push(o.mask)}function _(v){let w=u[v.type],F;if(w){let D=nn[w];F=qr.clone(D.uniforms)}else F=v.uniforms;return F}function M(v,w){let F=h.get(w);return F!==void 0?++F.usedTimes:(F=new nS(i,w,v,s),c.push(F),h.set(w,F)),F}function y(v){if(--v.usedTimes===0){let w=c.indexOf(v);c[w]=c[c.length-1],c.pop(),h.delete(v.cacheKey),v.destroy()}}function T(v){a.remove(v)}function E(){a.dispose()}return{getParameters:g,getProgramCacheKey:x,getUniforms:_,acquireProgram:M,releaseProgram:y,releaseShaderCache:T,programs:c,dispose:E}}function oS(){let i=new WeakMap;function t(o){return i.has(o)}function e(o){let a=i.get(o);return a===void 0&&(a={},i.set(o,a)),a}function n(o){i.delete(o)}function s(o,a,l){i.get(o)[a]=l}function r(){i=new WeakMap}return{has:t,get:e,remove:n,update:s,dispose:r}}function aS(i,t){return i.groupOrder!==t.groupOrder?i.groupOrder-t.groupOrder:i.renderOrder!==t.renderOrder?i.renderOrder-t.renderOrder:i.material.id!==t.material.id?i.material.id-t.material.id:i.materialVariant!==t.materialVariant?i.materialVariant-t.materialVariant:i.z!==t.z?i.z-t.z:i.id-t.id}function Ep(i,t){return i.groupOrder!==t.groupOrder?i.groupOrder-t.groupOrder:i.renderOrder!==t.renderOrder?i.renderOrder-t.renderOrder:i.z!==t.z?t.z-i.z:i.id-t.id}function Ap(){let i=[],t=0,e=[],n=[],s=[];function r(){t=0,e.length=0,n.length=0,s.length=0}function o(u){let f=0;return u.isInstancedMesh&&(f+=2),u.isSkinnedMesh&&(f+=1),f}function a(u,f,g,x,p,m){let _=i[t];return _===void 0?(_={id:u.id,object:u,geometry:f,material:g,materialVariant:o(u),groupOrder:x,renderOrder:u.renderOrder,z:p,group:m},i[t]=_):(_.id=u.id,_.object=u,_.geometry=f,_.material=g,_.materialVariant=o(u),_.groupOrder=x,_.renderOrder=u.renderOrder,_.z=p,_.group=m),t++,_}function l(u,f,g,x,p,m,_){_.reversedDepth===!0&&(p=-p);let M=a(u,f,g,x,p,m);g.transmission>0?n.push(M):g.transparent===!0?s.push(M):e.push(M)}function c(u,f,g,x,p,m){let _=a(u,f,g,x,p,m);g.transmission>0?n.unshift(_):g.transparent===!0?s.unshift(_):e.unshift(_)}function h(u,f){e.length>1&&e.sort(u||aS),n.length>1&&n.sort(f||Ep),s.length>1&&s.sort(f||Ep)}function d(){for(let u=t,f=i.length;u<f;u++){let g=i[u];if(g.id===null)break;g.id=null,g.object=null,g.geometry=null,g.material=null,g.group=null}}return{opaque:e,transmissive:n,transparent:s,init:r,push:l,unshift:c,finish:d,sort:h}}function lS(){let i=new WeakMap;function t(n,s){let r=i.get(n),o;return r===void 0?(o=new Ap,i.set(n,[o])):s>=r.length?(o=new Ap,r.push(o)):o=r[s],o}function e(){i=new WeakMap}return{get:t,dispose:e}}function cS(){let i={};return{get:function(t){if(i[t.id]!==void 0)return i[t.id];let e;switch(t.type){case"SunLight":case"DirectionalLight":e={direction:new P,color:new Gt};break;case"SpotLight":e={position:new P,direction:new P,color:new Gt,distance:0,coneCos:0,penumbraCos:0,decay:0};break;case"PointLight":e={position:new P,color:new Gt,distance:0,decay:0};break;case"HemisphereLight":e={direction:new P,skyColor:new Gt,groundColor:new Gt};break;case"RectAreaLight":e={color:new Gt,position:new P,halfWidth:new P,halfHeight:new P};break}return i[t.id]=e,e}}}function hS(){let i={};return{get:function(t){if(i[t.id]!==void 0)return i[t.id];let e;switch(t.type){case"SunLight":case"DirectionalLight":e={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new Ct};break;case"SpotLight":e={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new Ct};break;case"PointLight":e={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new Ct,shadowCameraNear:1,shadowCameraFar:1e3};break}return i[t.id]=e,e}}}var uS=0;function dS(i,t){return(t.castShadow?2:0)-(i.castShadow?2:0)+(t.map?1:0)-(i.map?1:0)}function fS(i){let t=new cS,e=hS(),n={version:0,hash:{sunLength:-1,directionalLength:-1,pointLength:-1,spotLength:-1,rectAreaLength:-1,hemiLength:-1,numSunShadows:-1,numDirectionalShadows:-1,numPointShadows:-1,numSpotShadows:-1,numSpotMaps:-1,numLightProbes:-1},ambient:[0,0,0],probe:[],sun:[],sunShadow:[],sunShadowMap:[],sunShadowMatrix:[],sunShadowCascade:[],directional:[],directionalShadow:[],directionalShadowMap:[],directionalShadowMatrix:[],spot:[],spotLightMap:[],spotShadow:[],spotShadowMap:[],spotLightMatrix:[],rectArea:[],rectAreaLTC1:null,rectAreaLTC2:null,point:[],pointShadow:[],pointShadowMap:[],pointShadowMatrix:[],hemi:[],numSpotLightShadowsWithMaps:0,numLightProbes:0};for(let c=0;c<9;c++)n.probe.push(new P);let s=new P,r=new jt,o=new jt;function a(c){let h=0,d=0,u=0;for(let O=0;O<9;O++)n.probe[O].set(0,0,0);let f=0,g=0,x=0,p=0,m=0,_=0,M=0,y=0,T=0,E=0,v=0,w=0,F=0,D=0;c.sort(dS);for(let O=0,V=c.length;O<V;O++){let C=c[O],H=C.color,X=C.intensity,G=C.distance,nt=null;if(C.shadow&&C.shadow.map&&(C.shadow.map.texture.format===zi?nt=C.shadow.map.texture:nt=C.shadow.map.depthTexture||C.shadow.map.texture),C.isAmbientLight)h+=H.r*X,d+=H.g*X,u+=H.b*X;else if(C.isLightProbe){for(let $=0;$<9;$++)n.probe[$].addScaledVector(C.sh.coefficients[$],X);D++}else if(C.isSunLight){let $=t.get(C);if($.color.copy(C.color).multiplyScalar(C.intensity),C.castShadow){let Q=C.shadow,et=e.get(C);et.shadowIntensity=Q.intensity,et.shadowBias=Q.bias,et.shadowNormalBias=Q.normalBias,et.shadowRadius=Q.radius,et.shadowMapSize.copy(Q.mapSize).multiply(Q.getFrameExtents()),n.sunShadow[g]=et,n.sunShadowMap[g]=nt;let yt=Q.getViewportCount();for(let Dt=0;Dt<yt;Dt++)n.sunShadowMatrix[x+Dt]=Q.getMatrix(Dt),n.sunShadowCascade[x+Dt]=Q._cascadeData[Dt];x+=yt,g++}n.sun[f]=$,f++}else if(C.isDirectionalLight){let $=t.get(C);if($.color.copy(C.color).multiplyScalar(C.intensity),C.castShadow){let Q=C.shadow,et=e.get(C);et.shadowIntensity=Q.intensity,et.shadowBias=Q.bias,et.shadowNormalBias=Q.normalBias,et.shadowRadius=Q.radius,et.shadowMapSize=Q.mapSize,n.directionalShadow[p]=et,n.directionalShadowMap[p]=nt,n.directionalShadowMatrix[p]=C.shadow.matrix,T++}n.directional[p]=$,p++}else if(C.isSpotLight){let $=t.get(C);$.position.setFromMatrixPosition(C.matrixWorld),$.color.copy(H).multiplyScalar(X),$.distance=G,$.coneCos=Math.cos(C.angle),$.penumbraCos=Math.cos(C.angle*(1-C.penumbra)),$.decay=C.decay,n.spot[_]=$;let Q=C.shadow;if(C.map&&(n.spotLightMap[w]=C.map,w++,Q.updateMatrices(C),C.castShadow&&F++),n.spotLightMatrix[_]=Q.matrix,C.castShadow){let et=e.get(C);et.shadowIntensity=Q.intensity,et.shadowBias=Q.bias,et.shadowNormalBias=Q.normalBias,et.shadowRadius=Q.radius,et.shadowMapSize=Q.mapSize,n.spotShadow[_]=et,n.spotShadowMap[_]=nt,v++}_++}else if(C.isRectAreaLight){let $=t.get(C);$.color.copy(H).multiplyScalar(X),$.halfWidth.set(C.width*.5,0,0),$.halfHeight.set(0,C.height*.5,0),n.rectArea[M]=$,M++}else if(C.isPointLight){let $=t.get(C);if($.color.copy(C.color).multiplyScalar(C.intensity),$.distance=C.distance,$.decay=C.decay,C.castShadow){let Q=C.shadow,et=e.get(C);et.shadowIntensity=Q.intensity,et.shadowBias=Q.bias,et.shadowNormalBias=Q.normalBias,et.shadowRadius=Q.radius,et.shadowMapSize=Q.mapSize,et.shadowCameraNear=Q.camera.near,et.shadowCameraFar=Q.camera.far,n.pointShadow[m]=et,n.pointShadowMap[m]=nt,n.pointShadowMatrix[m]=C.shadow.matrix,E++}n.point[m]=$,m++}else if(C.isHemisphereLight){let $=t.get(C);$.skyColor.copy(C.color).multiplyScalar(X),$.groundColor.copy(C.groundColor).multiplyScalar(X),n.hemi[y]=$,y++}}M>0&&(i.has("OES_texture_float_linear")===!0?(n.rectAreaLTC1=ft.LTC_FLOAT_1,n.rectAreaLTC2=ft.LTC_FLOAT_2):(n.rectAreaLTC1=ft.LTC_HALF_1,n.rectAreaLTC2=ft.LTC_HALF_2)),n.ambient[0]=h,n.ambient[1]=d,n.ambient[2]=u;let N=n.hash;(N.sunLength!==f||N.directionalLength!==p||N.pointLength!==m||N.spotLength!==_||N.rectAreaLength!==M||N.hemiLength!==y||N.numSunShadows!==g||N.numDirectionalShadows!==T||N.numPointShadows!==E||N.numSpotShadows!==v||N.numSpotMaps!==w||N.numLightProbes!==D)&&(n.sun.length=f,n.directional.length=p,n.spot.length=_,n.rectArea.length=M,n.point.length=m,n.hemi.length=y,n.sunShadow.length=g,n.sunShadowMap.length=g,n.sunShadowMatrix.length=x,n.sunShadowCascade.length=x,n.directionalShadow.length=T,n.directionalShadowMap.length=T,n.directionalShadowMatrix.length=T,n.pointShadow.length=E,n.pointShadowMap.length=E,n.pointShadowMatrix.length=E,n.spotShadow.length=v,n.spotShadowMap.length=v,n.spotLightMatrix.length=v+w-F,n.spotLightMap.length=w,n.numSpotLightShadowsWithMaps=F,n.numLightProbes=D,N.sunLength=f,N.directionalLength=p,N.pointLength=m,N.spotLength=_,N.rectAreaLength=M,N.hemiLength=y,N.numSunShadows=g,N.numDirectionalShadows=T,N.numPointShadows=E,N.numSpotShadows=v,N.numSpotMaps=w,N.numLightProbes=D,n.version=uS++)}function l(c,h){let d=0,u=0,f=0,g=0,x=0,p=0,m=h.matrixWorldInverse;for(let _=0,M=c.length;_<M;_++){let y=c[_];if(y.isSunLight){let T=n.sun[d];T.direction.setFromMatrixPosition(y.matrixWorld),T.direction.transformDirection(m),d++}else if(y.isDirectionalLight){let T=n.directional[u];T.direction.setFromMatrixPosition(y.matrixWorld),s.setFromMatrixPosition(y.target.matrixWorld),T.direction.sub(s),T.direction.transformDirection(m),u++}else if(y.isSpotLight){let T=n.spot[g];T.position.setFromMatrixPosition(y.matrixWorld),T.position.applyMatrix4(m),T.direction.setFromMatrixPosition(y.matrixWorld),s.setFromMatrixPosition(y.target.matrixWorld),T.direction.sub(s),T.direction.transformDirection(m),g++}else if(y.isRectAreaLight){let T=n.rectArea[x];T.position.setFromMatrixPosition(y.matrixWorld),T.position.applyMatrix4(m),o.identity(),r.copy(y.matrixWorld),r.premultiply(m),o.extractRotation(r),T.halfWidth.set(y.width*.5,0,0),T.halfHeight.set(0,y.height*.5,0),T.halfWidth.applyMatrix4(o),T.halfHeight.applyMatrix4(o),x++}else if(y.isPointLight){let T=n.point[f];T.position.setFromMatrixPosition(y.matrixWorld),T.position.applyMatrix4(m),f++}else if(y.isHemisphereLight){let T=n.hemi[p];T.direction.setFromMatrixPosition(y.matrixWorld),T.direction.transformDirection(m),p++}}}return{setup:a,setupView:l,state:n}}function Tp(i){let t=new fS(i),e=[],n=[],s=[];function r(d){h.camera=d,e.length=0,n.length=0,s.length=0}function o(d){d.isLightProbeGrid?s.push(d):e.push(d)}function a(d){n.push(d)}function l(){t.setup(e),s.sort((d,u)=>d.priority-u.priority||d.id-u.id)}function c(d){t.setupView(e,d)}let h={lightsArray:e,shadowsArray:n,lightProbeGridArray:s,camera:null,lights:t,transmissionRenderTarget:{},textureUnits:0};return{init:r,state:h,setupLights:l,setupLightsView:c,pushLight:o,pushShadow:a}}function pS(i){let t=new WeakMap;function e(s,r=0){let o=t.get(s),a;return o===void 0?(a=new Tp(i),t.set(s,[a])):r>=o.length?(a=new Tp(i),o.push(a)):a=o[r],a}function n(){t=new WeakMap}return{get:e,dispose:n}}var mS=`void main() {
	gl_Position = vec4( position, 1.0 );
}`,gS=`uniform sampler2D shadow_pass;
uniform vec2 resolution;
uniform float radius;
void main() {
	const float samples = float( VSM_SAMPLES );
	float mean = 0.0;
	float squared_mean = 0.0;
	float uvStride = samples <= 1.0 ? 0.0 : 2.0 / ( samples - 1.0 );
	float uvStart = samples <= 1.0 ? 0.0 : - 1.0;
	for ( float i = 0.0; i < samples; i ++ ) {
		float uvOffset = uvStart + i * uvStride;
		#ifdef HORIZONTAL_PASS
			vec2 distribution = texture2D( shadow_pass, ( gl_FragCoord.xy + vec2( uvOffset, 0.0 ) * radius ) / resolution ).rg;
			mean += distribution.x;
			squared_mean += distribution.y * distribution.y + distribution.x * distribution.x;
		#else
			float depth = texture2D( shadow_pass, ( gl_FragCoord.xy + vec2( 0.0, uvOffset ) * radius ) / resolution ).r;
			mean += depth;
			squared_mean += depth * depth;
		#endif
	}
	mean = mean / samples;
	squared_mean = squared_mean / samples;
	float std_dev = sqrt( max( 0.0, squared_mean - mean * mean ) );
	gl_FragColor = vec4( mean, std_dev, 0.0, 1.0 );
}`,vS=[new P(1,0,0),new P(-1,0,0),new P(0,1,0),new P(0,-1,0),new P(0,0,1),new P(0,0,-1)],xS=[new P(0,-1,0),new P(0,-1,0),new P(0,0,1),new P(0,0,-1),new P(0,-1,0),new P(0,-1,0)],Cp=new jt,Yr=new P,au=new P;function _S(i,t,e){let n=new es,s=new Ct,r=new Ct,o=new ne,a=new _a,l=new ya,c={},h=e.maxTextureSize,d={[zn]:Ae,[Ae]:zn,[en]:en},u=new Ln({defines:{VSM_SAMPLES:8},uniforms:{shadow_pass:{value:null},resolution:{value:new Ct},radius:{value:4}},vertexShader:mS,fragmentShader:gS}),f=u.clone();f.defines.HORIZONTAL_PASS=1;let g=new he;g.setAttribute("position",new qe(new Float32Array([-1,-1,.5,3,-1,.5,-1,3,.5]),3));let x=new me(g,u),p=this;this.enabled=!1,this.autoUpdate=!0,this.needsUpdate=!1,this.type=kr;let m=this.type;this.render=function(E,v,w){if(p.enabled===!1||p.autoUpdate===!1&&p.needsUpdate===!1||E.length===0)return;this.type===bf&&(Tt("WebGLShadowMap: PCFSoftShadowMap has been removed. Using PCFShadowMap instead."),this.type=kr);let F=i.getRenderTarget(),D=i.getActiveCubeFace(),N=i.getActiveMipmapLevel(),O=i.state;O.setBlending(is),O.buffers.depth.getReversed()===!0?O.buffers.color.setClear(0,0,0,0):O.buffers.color.setClear(1,1,1,1),O.buffers.depth.setTest(!0),O.setScissorTest(!1);let V=m!==this.type;V&&v.traverse(function(C){C.material&&(Array.isArray(C.material)?C.material.forEach(H=>H.needsUpdate=!0):C.material.needsUpdate=!0)});for(let C=0,H=E.length;C<H;C++){let X=E[C],G=X.shadow;if(G===void 0){Tt("WebGLShadowMap:",X,"has no shadow.");continue}if(G.autoUpdate===!1&&G.needsUpdate===!1)continue;s.copy(G.mapSize);let nt=G.getFrameExtents();s.multiply(nt),r.copy(G.mapSize),(s.x>h||s.y>h)&&(s.x>h&&(r.x=Math.floor(h/nt.x),s.x=r.x*nt.x,G.mapSize.x=r.x),s.y>h&&(r.y=Math.floor(h/nt.y),s.y=r.y*nt.y,G.mapSize.y=r.y));let $=i.state.buffers.depth.getReversed();if(G.camera._reversedDepth=$,G.map===null||V===!0){if(G.map!==null&&(G.map.depthTexture!==null&&(G.map.depthTexture.dispose(),G.map.depthTexture=null),G.map.dispose()),this.type===zs){if(X.isPointLight){Tt("WebGLShadowMap: VSM shadow maps are not supported for PointLights. Use PCF or BasicShadowMap instead.");continue}G.map=new pn(s.x,s.y,{format:zi,type:xn,minFilter:Be,magFilter:Be,generateMipmaps:!1}),G.map.texture.name=X.name+".shadowMap",G.map.depthTexture=new mi(s.x,s.y,Gn),G.map.depthTexture.name=X.name+".shadowMapDepth",G.map.depthTexture.format=di,G.map.depthTexture.compareFunction=null,G.map.depthTexture.minFilter=Ue,G.map.depthTexture.magFilter=Ue}else X.isPointLight?(G.map=new Zr(s.x),G.map.depthTexture=new Er(s.x,Hn)):(G.map=new pn(s.x,s.y),G.map.depthTexture=new mi(s.x,s.y,Hn)),G.map.depthTexture.name=X.name+".shadowMap",G.map.depthTexture.format=di,this.type===kr?(G.map.depthTexture.compareFunction=$?Yh:qh,G.map.depthTexture.minFilter=Be,G.map.depthTexture.magFilter=Be):(G.map.depthTexture.compareFunction=null,G.map.depthTexture.minFilter=Ue,G.map.depthTexture.magFilter=Ue);G.camera.updateProjectionMatrix()}G.map.isWebGLCubeRenderTarget!==!0&&(G.map.width!==s.x||G.map.height!==s.y)&&G.map.setSize(s.x,s.y);let Q=G.map.isWebGLCubeRenderTarget?6:G.getViewportCount();X.isPointLight!==!0&&G.updateMatrices(X,w);let et=(G.camera.layers.mask&4294967294)!==0?G.camera.layers:w.layers;for(let yt=0;yt<Q;yt++){let Dt=G.getCamera(yt);if(X.isPointLight){let Z=G.camera,gt=G.matrix,bt=X.distance||Z.far;bt!==Z.far&&(Z.far=bt,Z.updateProjectionMatrix()),Yr.setFromMatrixPosition(X.matrixWorld),Z.position.copy(Yr),au.copy(Z.position),au.add(vS[yt]),Z.up.copy(xS[yt]),Z.lookAt(au),Z.updateMatrixWorld(),gt.makeTranslation(-Yr.x,-Yr.y,-Yr.z),Cp.multiplyMatrices(Z.projectionMatrix,Z.matrixWorldInverse),G._frustum.setFromProjectionMatrix(Cp,Z.coordinateSystem,Z.reversedDepth)}if(G.map.isWebGLCubeRenderTarget)i.setRenderTarget(G.map,yt),i.clear();else{yt===0&&(i.setRenderTarget(G.map),i.clear());let Z=G.getViewport(yt);o.set(r.x*Z.x,r.y*Z.y,r.x*Z.z,r.y*Z.w),O.viewport(o)}n=G.getFrustum(yt),y(v,w,Dt,X,et,this.type)}G.isPointLightShadow!==!0&&this.type===zs&&_(G,w),G.needsUpdate=!1}m=this.type,p.needsUpdate=!1,i.setRenderTarget(F,D,N)};function _(E,v){let w=t.update(x);u.defines.VSM_SAMPLES!==E.blurSamples&&(u.defines.VSM_SAMPLES=E.blurSamples,f.defines.VSM_SAMPLES=E.blurSamples,u.needsUpdate=!0,f.needsUpdate=!0),E.mapPass===null?E.mapPass=new pn(s.x,s.y,{format:zi,type:xn}):(E.mapPass.width!==E.map.width||E.mapPass.height!==E.map.height)&&E.mapPass.setSize(E.map.width,E.map.height),u.uniforms.shadow_pass.value=E.map.depthTexture,u.uniforms.resolution.value.set(E.map.width,E.map.height),u.uniforms.radius.value=E.radius,i.setRenderTarget(E.mapPass),i.clear(),i.renderBufferDirect(v,null,w,u,x,null),f.uniforms.shadow_pass.value=E.mapPass.texture,f.uniforms.resolution.value.set(E.map.width,E.map.height),f.uniforms.radius.value=E.radius,i.setRenderTarget(E.map),i.clear(),i.renderBufferDirect(v,null,w,f,x,null)}function M(E,v,w,F){let D=null,N=w.isPointLight===!0?E.customDistanceMaterial:E.customDepthMaterial;if(N!==void 0)D=N;else if(D=w.isPointLight===!0?l:a,i.localClippingEnabled&&v.clipShadows===!0&&Array.isArray(v.clippingPlanes)&&v.clippingPlanes.length!==0||v.displacementMap&&v.displacementScale!==0||v.alphaMap&&v.alphaTest>0||v.map&&v.alphaTest>0||v.alphaToCoverage===!0){let O=D.uuid,V=v.uuid,C=c[O];C===void 0&&(C={},c[O]=C);let H=C[V];H===void 0&&(H=D.clone(),C[V]=H,v.addEventListener("dispose",T)),D=H}if(D.visible=v.visible,D.wireframe=v.wireframe,F===zs?D.side=v.shadowSide!==null?v.shadowSide:v.side:D.side=v.shadowSide!==null?v.shadowSide:d[v.side],D.alphaMap=v.alphaMap,D.alphaTest=v.alphaToCoverage===!0?.5:v.alphaTest,D.map=v.map,D.clipShadows=v.clipShadows,D.clippingPlanes=v.clippingPlanes,D.clipIntersection=v.clipIntersection,D.displacementMap=v.displacementMap,D.displacementScale=v.displacementScale,D.displacementBias=v.displacementBias,D.wireframeLinewidth=v.wireframeLinewidth,D.linewidth=v.linewidth,w.isPointLight===!0&&D.isMeshDistanceMaterial===!0){let O=i.properties.get(D);O.light=w}return D}function y(E,v,w,F,D,N){if(E.visible===!1)return;if(E.layers.test(D)&&(E.isMesh||E.isLine||E.isPoints)&&(E.castShadow||E.receiveShadow&&N===zs)&&(!E.frustumCulled||E.intersectsFrustum(n))){E.modelViewMatrix.multiplyMatrices(w.matrixWorldInverse,E.matrixWorld);let C=t.update(E),H=E.material;if(Array.isArray(H)){let X=C.groups;for(let G=0,nt=X.length;G<nt;G++){let $=X[G],Q=H[$.materialIndex];if(Q&&Q.visible){let et=M(E,Q,F,N);E.onBeforeShadow(i,E,v,w,C,et,$),i.renderBufferDirect(w,null,C,et,E,$),E.onAfterShadow(i,E,v,w,C,et,$)}}}else if(H.visible){let X=M(E,H,F,N);E.onBeforeShadow(i,E,v,w,C,X,null),i.renderBufferDirect(w,null,C,X,E,null),E.onAfterShadow(i,E,v,w,C,X,null)}}let V=E.children;for(let C=0,H=V.length;C<H;C++)y(V[C],v,w,F,D,N)}function T(E){E.target.removeEventListener("dispose",T);for(let w in c){let F=c[w],D=E.target.uuid;D in F&&(F[D].dispose(),delete F[D])}}}function yS(i,t){function e(){let R=!1,K=new ne,q=null,ct=new ne(0,0,0,0);return{setMask:function(rt){q!==rt&&!R&&(i.colorMask(rt,rt,rt,rt),q=rt)},setLocked:function(rt){R=rt},setClear:function(rt,at,Et,zt,st){st===!0&&(rt*=zt,at*=zt,Et*=zt),K.set(rt,at,Et,zt),ct.equals(K)===!1&&(i.clearColor(rt,at,Et,zt),ct.copy(K))},reset:function(){R=!1,q=null,ct.set(-1,0,0,0)}}}function n(){let R=!1,K=!1,q=null,ct=null,rt=null;return{setReversed:function(at){if(K!==at){let Et=t.get("EXT_clip_control");at?Et.clipControlEXT(Et.LOWER_LEFT_EXT,Et.ZERO_TO_ONE_EXT):Et.clipControlEXT(Et.LOWER_LEFT_EXT,Et.NEGATIVE_ONE_TO_ONE_EXT),K=at;let zt=rt;rt=null,this.setClear(zt)}},getReversed:function(){return K},setTest:function(at){at?vt(i.DEPTH_TEST):Bt(i.DEPTH_TEST)},setMask:function(at){q!==at&&!R&&(i.depthMask(at),q=at)},setFunc:function(at){if(K&&(at=tp[at]),ct!==at){switch(at){case ea:i.depthFunc(i.NEVER);break;case na:i.depthFunc(i.ALWAYS);break;case ia:i.depthFunc(i.LESS);break;case Ts:i.depthFunc(i.LEQUAL);break;case Cs:i.depthFunc(i.EQUAL);break;case sa:i.depthFunc(i.GEQUAL);break;case ra:i.depthFunc(i.GREATER);break;case oa:i.depthFunc(i.NOTEQUAL);break;default:i.depthFunc(i.LEQUAL)}ct=at}},setLocked:function(at){R=at},setClear:function(at){rt!==at&&(rt=at,K&&(at=1-at),i.clearDepth(at))},reset:function(){R=!1,q=null,ct=null,rt=null,K=!1}}}function s(){let R=!1,K=null,q=null,ct=null,rt=null,at=null,Et=null,zt=null,st=null;return{setTest:function(At){R||(At?vt(i.STENCIL_TEST):Bt(i.STENCIL_TEST))},setMask:function(At){K!==At&&!R&&(i.stencilMask(At),K=At)},setFunc:function(At,kt,mt){(q!==At||ct!==kt||rt!==mt)&&(i.stencilFunc(At,kt,mt),q=At,ct=kt,rt=mt)},setOp:function(At,kt,mt){(at!==At||Et!==kt||zt!==mt)&&(i.stencilOp(At,kt,mt),at=At,Et=kt,zt=mt)},setLocked:function(At){R=At},setClear:function(At){st!==At&&(i.clearStencil(At),st=At)},reset:function(){R=!1,K=null,q=null,ct=null,rt=null,at=null,Et=null,zt=null,st=null}}}let r=new e,o=new n,a=new s,l={},c=new WeakMap,h={},d={},u={},f=new WeakMap,g=[],x=null,p=!1,m=null,_=null,M=null,y=null,T=null,E=null,v=null,w=new Gt(0,0,0),F=0,D=!1,N=null,O=null,V=null,C=null,H=null,X=i.getParameter(i.MAX_COMBINED_TEXTURE_IMAGE_UNITS),G=!1,nt=0,$=i.getParameter(i.VERSION);$.indexOf("WebGL")!==-1?(nt=parseFloat(/^WebGL (\d)/.exec($)[1]),G=nt>=1):$.indexOf("OpenGL ES")!==-1&&(nt=parseFloat(/^OpenGL ES (\d)/.exec($)[1]),G=nt>=2);let Q=null,et={},yt=i.getParameter(i.SCISSOR_BOX),Dt=i.getParameter(i.VIEWPORT),Z=new ne().fromArray(yt),gt=new ne().fromArray(Dt);function bt(R,K,q,ct){let rt=new Uint8Array(4),at=i.createTexture();i.bindTexture(R,at),i.texParameteri(R,i.TEXTURE_MIN_FILTER,i.NEAREST),i.texParameteri(R,i.TEXTURE_MAG_FILTER,i.NEAREST);for(let Et=0;Et<q;Et++)R===i.TEXTURE_3D||R===i.TEXTURE_2D_ARRAY?i.texImage3D(K,0,i.RGBA,1,1,ct,0,i.RGBA,i.UNSIGNED_BYTE,rt):i.texImage2D(K+Et,0,i.RGBA,1,1,0,i.RGBA,i.UNSIGNED_BYTE,rt);return at}let Rt={};Rt[i.TEXTURE_2D]=bt(i.TEXTURE_2D,i.TEXTURE_2D,1),Rt[i.TEXTURE_CUBE_MAP]=bt(i.TEXTURE_CUBE_MAP,i.TEXTURE_CUBE_MAP_POSITIVE_X,6),Rt[i.TEXTURE_2D_ARRAY]=bt(i.TEXTURE_2D_ARRAY,i.TEXTURE_2D_ARRAY,1,1),Rt[i.TEXTURE_3D]=bt(i.TEXTURE_3D,i.TEXTURE_3D,1,1),r.setClear(0,0,0,1),o.setClear(1),a.setClear(0),vt(i.DEPTH_TEST),o.setFunc(Ts),rn(!1),de(bh),vt(i.CULL_FACE),Fe(is);function vt(R){h[R]!==!0&&(i.enable(R),h[R]=!0)}function Bt(R){h[R]!==!1&&(i.disable(R),h[R]=!1)}function xe(R,K){return u[R]!==K?(i.bindFramebuffer(R,K),u[R]=K,R===i.DRAW_FRAMEBUFFER&&(u[i.FRAMEBUFFER]=K),R===i.FRAMEBUFFER&&(u[i.DRAW_FRAMEBUFFER]=K),!0):!1}function It(R,K){let q=g,ct=!1;if(R){q=f.get(K),q===void 0&&(q=[],f.set(K,q));let rt=R.textures;if(q.length!==rt.length||q[0]!==i.COLOR_ATTACHMENT0){for(let at=0,Et=rt.length;at<Et;at++)q[at]=i.COLOR_ATTACHMENT0+at;q.length=rt.length,ct=!0}}else q[0]!==i.BACK&&(q[0]=i.BACK,ct=!0);ct&&i.drawBuffers(q)}function te(R){return x!==R?(i.useProgram(R),x=R,!0):!1}let ie={[ss]:i.FUNC_ADD,[Mf]:i.FUNC_SUBTRACT,[wf]:i.FUNC_REVERSE_SUBTRACT};ie[Ef]=i.MIN,ie[Af]=i.MAX;let Vt={[Tf]:i.ZERO,[Cf]:i.ONE,[Rf]:i.SRC_COLOR,[Eh]:i.SRC_ALPHA,[Uf]:i.SRC_ALPHA_SATURATE,[Df]:i.DST_COLOR,[If]:i.DST_ALPHA,[Pf]:i.ONE_MINUS_SRC_COLOR,[Ah]:i.ONE_MINUS_SRC_ALPHA,[Nf]:i.ONE_MINUS_DST_COLOR,[Lf]:i.ONE_MINUS_DST_ALPHA,[Ff]:i.CONSTANT_COLOR,[Of]:i.ONE_MINUS_CONSTANT_COLOR,[Bf]:i.CONSTANT_ALPHA,[kf]:i.ONE_MINUS_CONSTANT_ALPHA};function Fe(R,K,q,ct,rt,at,Et,zt,st,At){if(R===is){p===!0&&(Bt(i.BLEND),p=!1);return}if(p===!1&&(vt(i.BLEND),p=!0),R!==Sf){if(R!==m||At!==D){if((_!==ss||T!==ss)&&(i.blendEquation(i.FUNC_ADD),_=ss,T=ss),At)switch(R){case Hs:i.blendFuncSeparate(i.ONE,i.ONE_MINUS_SRC_ALPHA,i.ONE,i.ONE_MINUS_SRC_ALPHA);break;case Sh:i.blendFunc(i.ONE,i.ONE);break;case Mh:i.blendFuncSeparate(i.ZERO,i.ONE_MINUS_SRC_COLOR,i.ZERO,i.ONE);break;case wh:i.blendFuncSeparate(i.DST_COLOR,i.ONE_MINUS_SRC_ALPHA,i.ZERO,i.ONE);break;default:Lt("WebGLState: Invalid blending: ",R);break}else switch(R){case Hs:i.blendFuncSeparate(i.SRC_ALPHA,i.ONE_MINUS_SRC_ALPHA,i.ONE,i.ONE_MINUS_SRC_ALPHA);break;case Sh:i.blendFuncSeparate(i.SRC_ALPHA,i.ONE,i.ONE,i.ONE);break;case Mh:Lt("WebGLState: SubtractiveBlending requires material.premultipliedAlpha = true");break;case wh:Lt("WebGLState: MultiplyBlending requires material.premultipliedAlpha = true");break;default:Lt("WebGLState: Invalid blending: ",R);break}M=null,y=null,E=null,v=null,w.set(0,0,0),F=0,m=R,D=At}return}rt=rt||K,at=at||q,Et=Et||ct,(K!==_||rt!==T)&&(i.blendEquationSeparate(ie[K],ie[rt]),_=K,T=rt),(q!==M||ct!==y||at!==E||Et!==v)&&(i.blendFuncSeparate(Vt[q],Vt[ct],Vt[at],Vt[Et]),M=q,y=ct,E=at,v=Et),(zt.equals(w)===!1||st!==F)&&(i.blendColor(zt.r,zt.g,zt.b,st),w.copy(zt),F=st),m=R,D=!1}function Me(R,K){R.side===en?Bt(i.CULL_FACE):vt(i.CULL_FACE);let q=R.side===Ae;K&&(q=!q),rn(q),R.blending===Hs&&R.transparent===!1?Fe(is):Fe(R.blending,R.blendEquation,R.blendSrc,R.blendDst,R.blendEquationAlpha,R.blendSrcAlpha,R.blendDstAlpha,R.blendColor,R.blendAlpha,R.premultipliedAlpha),o.setFunc(R.depthFunc),o.setTest(R.depthTest),o.setMask(R.depthWrite),r.setMask(R.colorWrite);let ct=R.stencilWrite;a.setTest(ct),ct&&(a.setMask(R.stencilWriteMask),a.setFunc(R.stencilFunc,R.stencilRef,R.stencilFuncMask),a.setOp(R.stencilFail,R.stencilZFail,R.stencilZPass)),Pe(R.polygonOffset,R.polygonOffsetFactor,R.polygonOffsetUnits),R.alphaToCoverage===!0?vt(i.SAMPLE_ALPHA_TO_COVERAGE):Bt(i.SAMPLE_ALPHA_TO_COVERAGE)}function rn(R){N!==R&&(R?i.frontFace(i.CW):i.frontFace(i.CCW),N=R)}function de(R){R!==_f?(vt(i.CULL_FACE),R!==O&&(R===bh?i.cullFace(i.BACK):R===yf?i.cullFace(i.FRONT):i.cullFace(i.FRONT_AND_BACK))):Bt(i.CULL_FACE),O=R}function qn(R){R!==V&&(G&&i.lineWidth(R),V=R)}function Pe(R,K,q){R?(vt(i.POLYGON_OFFSET_FILL),(C!==K||H!==q)&&(C=K,H=q,o.getReversed()&&(K=-K,q=-q),i.polygonOffset(K,q))):Bt(i.POLYGON_OFFSET_FILL)}function Sn(R){R?vt(i.SCISSOR_TEST):Bt(i.SCISSOR_TEST)}function Mn(R){R===void 0&&(R=i.TEXTURE0+X-1),Q!==R&&(i.activeTexture(R),Q=R)}function wn(R,K,q){q===void 0&&(Q===null?q=i.TEXTURE0+X-1:q=Q);let ct=et[q];ct===void 0&&(ct={type:void 0,texture:void 0},et[q]=ct),(ct.type!==R||ct.texture!==K)&&(Q!==q&&(i.activeTexture(q),Q=q),i.bindTexture(R,K||Rt[R]),ct.type=R,ct.texture=K)}function U(){let R=et[Q];R!==void 0&&R.type!==void 0&&(i.bindTexture(R.type,null),R.type=void 0,R.texture=void 0)}function En(){try{i.compressedTexImage2D(...arguments)}catch(R){Lt("WebGLState:",R)}}function le(){try{i.compressedTexImage3D(...arguments)}catch(R){Lt("WebGLState:",R)}}function ce(){try{i.texSubImage2D(...arguments)}catch(R){Lt("WebGLState:",R)}}function pt(){try{i.texSubImage3D(...arguments)}catch(R){Lt("WebGLState:",R)}}function we(){try{i.compressedTexSubImage2D(...arguments)}catch(R){Lt("WebGLState:",R)}}function Pt(){try{i.compressedTexSubImage3D(...arguments)}catch(R){Lt("WebGLState:",R)}}function Ut(){try{i.texStorage2D(...arguments)}catch(R){Lt("WebGLState:",R)}}function A(){try{i.texStorage3D(...arguments)}catch(R){Lt("WebGLState:",R)}}function b(){try{i.texImage2D(...arguments)}catch(R){Lt("WebGLState:",R)}}function k(){try{i.texImage3D(...arguments)}catch(R){Lt("WebGLState:",R)}}function it(R){return d[R]!==void 0?d[R]:i.getParameter(R)}function J(R,K){d[R]!==K&&(i.pixelStorei(R,K),d[R]=K)}function ot(R){Z.equals(R)===!1&&(i.scissor(R.x,R.y,R.z,R.w),Z.copy(R))}function ut(R){gt.equals(R)===!1&&(i.viewport(R.x,R.y,R.z,R.w),gt.copy(R))}function Y(R,K){let q=c.get(K);q===void 0&&(q=new WeakMap,c.set(K,q));let ct=q.get(R);ct===void 0&&(ct=i.getUniformBlockIndex(K,R.name),i.uniformBlockBinding(K,ct,ct),q.set(R,ct))}function j(R,K,q){let rt=c.get(K).get(R);l[rt]!==q&&(i.bindBufferBase(i.UNIFORM_BUFFER,rt,q),l[rt]=q)}function lt(){i.disable(i.BLEND),i.disable(i.CULL_FACE),i.disable(i.DEPTH_TEST),i.disable(i.POLYGON_OFFSET_FILL),i.disable(i.SCISSOR_TEST),i.disable(i.STENCIL_TEST),i.disable(i.SAMPLE_ALPHA_TO_COVERAGE),i.blendEquation(i.FUNC_ADD),i.blendFunc(i.ONE,i.ZERO),i.blendFuncSeparate(i.ONE,i.ZERO,i.ONE,i.ZERO),i.blendColor(0,0,0,0),i.colorMask(!0,!0,!0,!0),i.clearColor(0,0,0,0),i.depthMask(!0),i.depthFunc(i.LESS),o.setReversed(!1),i.clearDepth(1),i.stencilMask(4294967295),i.stencilFunc(i.ALWAYS,0,4294967295),i.stencilOp(i.KEEP,i.KEEP,i.KEEP),i.clearStencil(0),i.cullFace(i.BACK),i.frontFace(i.CCW),i.polygonOffset(0,0),i.activeTexture(i.TEXTURE0),i.bindFramebuffer(i.FRAMEBUFFER,null),i.bindFramebuffer(i.DRAW_FRAMEBUFFER,null),i.bindFramebuffer(i.READ_FRAMEBUFFER,null),i.useProgram(null),i.lineWidth(1),i.scissor(0,0,i.canvas.width,i.canvas.height),i.viewport(0,0,i.canvas.width,i.canvas.height),i.pixelStorei(i.PACK_ALIGNMENT,4),i.pixelStorei(i.UNPACK_ALIGNMENT,4),i.pixelStorei(i.UNPACK_FLIP_Y_WEBGL,!1),i.pixelStorei(i.UNPACK_PREMULTIPLY_ALPHA_WEBGL,!1),i.pixelStorei(i.UNPACK_COLORSPACE_CONVERSION_WEBGL,i.BROWSER_DEFAULT_WEBGL),i.pixelStorei(i.PACK_ROW_LENGTH,0),i.pixelStorei(i.PACK_SKIP_PIXELS,0),i.pixelStorei(i.PACK_SKIP_ROWS,0),i.pixelStorei(i.UNPACK_ROW_LENGTH,0),i.pixelStorei(i.UNPACK_IMAGE_HEIGHT,0),i.pixelStorei(i.UNPACK_SKIP_PIXELS,0),i.pixelStorei(i.UNPACK_SKIP_ROWS,0),i.pixelStorei(i.UNPACK_SKIP_IMAGES,0),h={},d={},Q=null,et={},u={},l={},f=new WeakMap,g=[],x=null,p=!1,m=null,_=null,M=null,y=null,T=null,E=null,v=null,w=new Gt(0,0,0),F=0,D=!1,N=null,O=null,V=null,C=null,H=null,Z.set(0,0,i.canvas.width,i.canvas.height),gt.set(0,0,i.canvas.width,i.canvas.height),r.reset(),o.reset(),a.reset()}return{buffers:{color:r,depth:o,stencil:a},enable:vt,disable:Bt,bindFramebuffer:xe,drawBuffers:It,useProgram:te,setBlending:Fe,setMaterial:Me,setFlipSided:rn,setCullFace:de,setLineWidth:qn,setPolygonOffset:Pe,setScissorTest:Sn,activeTexture:Mn,bindTexture:wn,unbindTexture:U,compressedTexImage2D:En,compressedTexImage3D:le,texImage2D:b,texImage3D:k,pixelStorei:J,getParameter:it,updateUBOMapping:Y,uniformBlockBinding:j,texStorage2D:Ut,texStorage3D:A,texSubImage2D:ce,texSubImage3D:pt,compressedTexSubImage2D:we,compressedTexSubImage3D:Pt,scissor:ot,viewport:ut,reset:lt}}function bS(i,t,e,n,s,r,o){let a=t.has("WEBGL_multisampled_render_to_texture")?t.get("WEBGL_multisampled_render_to_texture"):null,l=typeof navigator>"u"?!1:/OculusBrowser/g.test(navigator.userAgent),c=new Ct,h=new WeakMap,d=new Set,u,f=new WeakMap,g=new Set,x=new FinalizationRegistry(A=>g.delete(A)),p=!1;try{p=typeof OffscreenCanvas<"u"&&new OffscreenCanvas(1,1).getContext("2d")!==null}catch{}function m(A,b){return p?new OffscreenCanvas(A,b):xr("canvas")}function _(A,b,k){let it=1,J=Ut(A);if((J.width>k||J.height>k)&&(it=k/Math.max(J.width,J.height)),it<1)if(typeof HTMLImageElement<"u"&&A instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&A instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&A instanceof ImageBitmap||typeof VideoFrame<"u"&&A instanceof VideoFrame){let ot=Math.floor(it*J.width),ut=Math.floor(it*J.height);u===void 0&&(u=m(ot,ut));let Y=b?m(ot,ut):u;return Y.width=ot,Y.height=ut,Y.getContext("2d").drawImage(A,0,0,ot,ut),Tt("WebGLRenderer: Texture has been resized from ("+J.width+"x"+J.height+") to ("+ot+"x"+ut+")."),Y}else return"data"in A&&Tt("WebGLRenderer: Image in DataTexture is too big ("+J.width+"x"+J.height+")."),A;return A}function M(A){return A.generateMipmaps}function y(A){i.generateMipmap(A)}function T(A){return A.isWebGLCubeRenderTarget?i.TEXTURE_CUBE_MAP:A.isWebGL3DRenderTarget?i.TEXTURE_3D:A.isWebGLArrayRenderTarget||A.isCompressedArrayTexture?i.TEXTURE_2D_ARRAY:i.TEXTURE_2D}function E(A,b,k,it,J,ot=!1){if(A!==null){if(i[A]!==void 0)return i[A];Tt("WebGLRenderer: Attempt to use non-existing WebGL internal format '"+A+"'")}let ut;it&&(ut=t.get("EXT_texture_norm16"),ut||Tt("WebGLRenderer: Unable to use normalized textures without EXT_texture_norm16 extension"));let Y=b;if(b===i.RED&&(k===i.FLOAT&&(Y=i.R32F),k===i.HALF_FLOAT&&(Y=i.R16F),k===i.UNSIGNED_BYTE&&(Y=i.R8),k===i.UNSIGNED_SHORT&&ut&&(Y=ut.R16_EXT),k===i.SHORT&&ut&&(Y=ut.R16_SNORM_EXT)),b===i.RED_INTEGER&&(k===i.UNSIGNED_BYTE&&(Y=i.R8UI),k===i.UNSIGNED_SHORT&&(Y=i.R16UI),k===i.UNSIGNED_INT&&(Y=i.R32UI),k===i.BYTE&&(Y=i.R8I),k===i.SHORT&&(Y=i.R16I),k===i.INT&&(Y=i.R32I)),b===i.RG&&(k===i.FLOAT&&(Y=i.RG32F),k===i.HALF_FLOAT&&(Y=i.RG16F),k===i.UNSIGNED_BYTE&&(Y=i.RG8),k===i.UNSIGNED_SHORT&&ut&&(Y=ut.RG16_EXT),k===i.SHORT&&ut&&(Y=ut.RG16_SNORM_EXT)),b===i.RG_INTEGER&&(k===i.UNSIGNED_BYTE&&(Y=i.RG8UI),k===i.UNSIGNED_SHORT&&(Y=i.RG16UI),k===i.UNSIGNED_INT&&(Y=i.RG32UI),k===i.BYTE&&(Y=i.RG8I),k===i.SHORT&&(Y=i.RG16I),k===i.INT&&(Y=i.RG32I)),b===i.RGB_INTEGER&&(k===i.UNSIGNED_BYTE&&(Y=i.RGB8UI),k===i.UNSIGNED_SHORT&&(Y=i.RGB16UI),k===i.UNSIGNED_INT&&(Y=i.RGB32UI),k===i.BYTE&&(Y=i.RGB8I),k===i.SHORT&&(Y=i.RGB16I),k===i.INT&&(Y=i.RGB32I)),b===i.RGBA_INTEGER&&(k===i.UNSIGNED_BYTE&&(Y=i.RGBA8UI),k===i.UNSIGNED_SHORT&&(Y=i.RGBA16UI),k===i.UNSIGNED_INT&&(Y=i.RGBA32UI),k===i.BYTE&&(Y=i.RGBA8I),k===i.SHORT&&(Y=i.RGBA16I),k===i.INT&&(Y=i.RGBA32I)),b===i.RGB&&(k===i.UNSIGNED_SHORT&&ut&&(Y=ut.RGB16_EXT),k===i.SHORT&&ut&&(Y=ut.RGB16_SNORM_EXT),k===i.UNSIGNED_INT_5_9_9_9_REV&&(Y=i.RGB9_E5),k===i.UNSIGNED_INT_10F_11F_11F_REV&&(Y=i.R11F_G11F_B10F)),b===i.RGBA){let j=ot?gr:Xt.getTransfer(J);k===i.FLOAT&&(Y=i.RGBA32F),k===i.HALF_FLOAT&&(Y=i.RGBA16F),k===i.UNSIGNED_BYTE&&(Y=j===Jt?i.SRGB8_ALPHA8:i.RGBA8),k===i.UNSIGNED_SHORT&&ut&&(Y=ut.RGBA16_EXT),k===i.SHORT&&ut&&(Y=ut.RGBA16_SNORM_EXT),k===i.UNSIGNED_SHORT_4_4_4_4&&(Y=i.RGBA4),k===i.UNSIGNED_SHORT_5_5_5_1&&(Y=i.RGB5_A1)}return(Y===i.R16F||Y===i.R32F||Y===i.RG16F||Y===i.RG32F||Y===i.RGBA16F||Y===i.RGBA32F)&&t.get("EXT_color_buffer_float"),Y}function v(A,b){let k;return A?b===null||b===Hn||b===os?k=i.DEPTH24_STENCIL8:b===Gn?k=i.DEPTH32F_STENCIL8:b===Vs&&(k=i.DEPTH24_STENCIL8,Tt("DepthTexture: 16 bit depth attachment is not supported with stencil. Using 24-bit attachment.")):b===null||b===Hn||b===os?k=i.DEPTH_COMPONENT24:b===Gn?k=i.DEPTH_COMPONENT32F:b===Vs&&(k=i.DEPTH_COMPONENT16),k}function w(A,b){return M(A)===!0||A.isFramebufferTexture&&A.minFilter!==Ue&&A.minFilter!==Be?Math.log2(Math.max(b.width,b.height))+1:A.mipmaps.length>0?A.mipmaps.length:A.isCompressedTexture&&Array.isArray(A.image)?b.mipmaps.length:1}function F(A){let b=new WeakRef(A);n.get(A).__ref=b,g.add(b),x.register(A,b,b)}function D(A){let b=n.get(A).__ref;b!==void 0&&(g.delete(b),x.unregister(b))}function N(A){V(A.target)}function O(A){C(A.target)}function V(A){A.removeEventListener("dispose",N),D(A),X(A),A.isVideoTexture&&h.delete(A),A.isHTMLTexture&&d.delete(A)}function C(A){A.removeEventListener("dispose",O),D(A),nt(A)}function H(){for(let A of g){let b=A.deref();b!==void 0&&(b.isRenderTarget===!0?C(b):V(b))}g.clear(),d.clear()}function X(A){let b=n.get(A);if(b.__webglInit===void 0)return;let k=A.source,it=f.get(k);if(it){let J=it[b.__cacheKey];J.usedTimes--,J.usedTimes===0&&G(A),Object.keys(it).length===0&&f.delete(k)}n.remove(A)}function G(A){let b=n.get(A);i.deleteTexture(b.__webglTexture);let k=A.source,it=f.get(k);delete it[b.__cacheKey],o.memory.textures--}function nt(A){let b=n.get(A);b.__depthDisposeCallback&&b.__depthDisposeCallback();let k=A.depthTexture;if(k&&k.renderTarget===A&&V(k),A.isWebGLCubeRenderTarget)for(let J=0;J<6;J++){if(Array.isArray(b.__webglFramebuffer[J]))for(let ot=0;ot<b.__webglFramebuffer[J].length;ot++)i.deleteFramebuffer(b.__webglFramebuffer[J][ot]);else i.deleteFramebuffer(b.__webglFramebuffer[J]);b.__webglDepthbuffer&&i.deleteRenderbuffer(b.__webglDepthbuffer[J])}else{if(Array.isArray(b.__webglFramebuffer))for(let J=0;J<b.__webglFramebuffer.length;J++)i.deleteFramebuffer(b.__webglFramebuffer[J]);else i.deleteFramebuffer(b.__webglFramebuffer);if(b.__webglDepthbuffer&&i.deleteRenderbuffer(b.__webglDepthbuffer),b.__webglMultisampledFramebuffer&&i.deleteFramebuffer(b.__webglMultisampledFramebuffer),b.__webglColorRenderbuffer)for(let J=0;J<b.__webglColorRenderbuffer.length;J++)b.__webglColorRenderbuffer[J]&&i.deleteRenderbuffer(b.__webglColorRenderbuffer[J]);b.__webglDepthRenderbuffer&&i.deleteRenderbuffer(b.__webglDepthRenderbuffer)}let it=A.textures;for(let J=0,ot=it.length;J<ot;J++){let ut=n.get(it[J]);ut.__webglTexture&&(i.deleteTexture(ut.__webglTexture),o.memory.textures--),n.remove(it[J])}n.remove(A)}let $=0;function Q(){$=0}function et(){return $}function yt(A){$=A}function Dt(){let A=$;return A>=s.maxTextures&&Tt("WebGLTextures: Trying to use "+(A+1)+" texture units while this GPU supports only "+s.maxTextures),$+=1,A}function Z(A){let b=[];return b.push(A.wrapS),b.push(A.wrapT),b.push(A.wrapR||0),b.push(A.magFilter),b.push(A.minFilter),b.push(A.anisotropy),b.push(A.internalFormat),b.push(A.format),b.push(A.type),b.push(A.generateMipmaps),b.push(A.mipmapsAutoUpdate),b.push(A.premultiplyAlpha),b.push(A.flipY),b.push(A.unpackAlignment),b.push(A.colorSpace),b.join()}function gt(A,b){let k=n.get(A);if(A.isVideoTexture&&we(A),A.isRenderTargetTexture===!1&&A.isExternalTexture!==!0&&A.version>0&&k.__version!==A.version){let it=A.image;if(it===null)Tt("WebGLRenderer: Texture marked for update but no image data found.");else if(it.complete===!1)Tt("WebGLRenderer: Texture marked for update but image is incomplete");else{Me(k,A,b);return}}else A.isExternalTexture&&(k.__webglTexture=A.sourceTexture?A.sourceTexture:null);e.bindTexture(i.TEXTURE_2D,k.__webglTexture,i.TEXTURE0+b)}function bt(A,b){let k=n.get(A);if(A.isRenderTargetTexture===!1&&A.version>0&&k.__version!==A.version){Me(k,A,b);return}else A.isExternalTexture&&(k.__webglTexture=A.sourceTexture?A.sourceTexture:null);e.bindTexture(i.TEXTURE_2D_ARRAY,k.__webglTexture,i.TEXTURE0+b)}function Rt(A,b){let k=n.get(A);if(A.isRenderTargetTexture===!1&&A.version>0&&k.__version!==A.version){Me(k,A,b);return}e.bindTexture(i.TEXTURE_3D,k.__webglTexture,i.TEXTURE0+b)}function vt(A,b){let k=n.get(A);if(A.version>0&&k.__version!==A.version){rn(k,A,b);return}e.bindTexture(i.TEXTURE_CUBE_MAP,k.__webglTexture,i.TEXTURE0+b)}let Bt={[aa]:i.REPEAT,[jn]:i.CLAMP_TO_EDGE,[la]:i.MIRRORED_REPEAT},xe={[Ue]:i.NEAREST,[Gf]:i.NEAREST_MIPMAP_NEAREST,[zr]:i.NEAREST_MIPMAP_LINEAR,[Be]:i.LINEAR,[Na]:i.LINEAR_MIPMAP_NEAREST,[gi]:i.LINEAR_MIPMAP_LINEAR},It={[Xf]:i.NEVER,[jh]:i.ALWAYS,[qf]:i.LESS,[qh]:i.LEQUAL,[Yf]:i.EQUAL,[Yh]:i.GEQUAL,[jf]:i.GREATER,[Zf]:i.NOTEQUAL};function te(A,b){if(b.type===Gn&&t.has("OES_texture_float_linear")===!1&&(b.magFilter===Be||b.magFilter===Na||b.magFilter===zr||b.magFilter===gi||b.minFilter===Be||b.minFilter===Na||b.minFilter===zr||b.minFilter===gi)&&Tt("WebGLRenderer: Unable to use linear filtering with floating point textures. OES_texture_float_linear not supported on this device."),i.texParameteri(A,i.TEXTURE_WRAP_S,Bt[b.wrapS]),i.texParameteri(A,i.TEXTURE_WRAP_T,Bt[b.wrapT]),(A===i.TEXTURE_3D||A===i.TEXTURE_2D_ARRAY)&&i.texParameteri(A,i.TEXTURE_WRAP_R,Bt[b.wrapR]),i.texParameteri(A,i.TEXTURE_MAG_FILTER,xe[b.magFilter]),i.texParameteri(A,i.TEXTURE_MIN_FILTER,xe[b.minFilter]),b.compareFunction&&(i.texParameteri(A,i.TEXTURE_COMPARE_MODE,i.COMPARE_REF_TO_TEXTURE),i.texParameteri(A,i.TEXTURE_COMPARE_FUNC,It[b.compareFunction])),t.has("EXT_texture_filter_anisotropic")===!0){if(b.magFilter===Ue||b.minFilter!==zr&&b.minFilter!==gi||b.type===Gn&&t.has("OES_texture_float_linear")===!1)return;if(b.anisotropy>1||n.get(b).__currentAnisotropy){let k=t.get("EXT_texture_filter_anisotropic");i.texParameterf(A,k.TEXTURE_MAX_ANISOTROPY_EXT,Math.min(b.anisotropy,s.getMaxAnisotropy())),n.get(b).__currentAnisotropy=b.anisotropy}}}function ie(A,b){let k=!1;A.__webglInit===void 0&&(A.__webglInit=!0,b.addEventListener("dispose",N),F(b));let it=b.source,J=f.get(it);J===void 0&&(J={},f.set(it,J));let ot=Z(b);if(ot!==A.__cacheKey){J[ot]===void 0&&(J[ot]={texture:i.createTexture(),usedTimes:0},o.memory.textures++,k=!0),J[ot].usedTimes++;let ut=J[A.__cacheKey];ut!==void 0&&(J[A.__cacheKey].usedTimes--,ut.usedTimes===0&&G(b)),A.__cacheKey=ot,A.__webglTexture=J[ot].texture}return k}function Vt(A,b,k){return Math.floor(Math.floor(A/k)/b)}function Fe(A,b,k,it){let ot=A.updateRanges;if(ot.length===0)e.texSubImage2D(i.TEXTURE_2D,0,0,0,b.width,b.height,k,it,b.data);else{ot.sort((R,K)=>R.start-K.start);let ut=0;for(let R=1;R<ot.length;R++){let K=ot[ut],q=ot[R],ct=K.start+K.count,rt=Vt(q.start,b.width,4),at=Vt(K.start,b.width,4);q.start<=ct+1&&rt===at&&Vt(q.start+q.count-1,b.width,4)===rt?K.count=Math.max(K.count,q.start+q.count-K.start):(++ut,ot[ut]=q)}ot.length=ut+1;let Y=e.getParameter(i.UNPACK_ROW_LENGTH),j=e.getParameter(i.UNPACK_SKIP_PIXELS),lt=e.getParameter(i.UNPACK_SKIP_ROWS);e.pixelStorei(i.UNPACK_ROW_LENGTH,b.width);for(let R=0,K=ot.length;R<K;R++){let q=ot[R],ct=Math.floor(q.start/4),rt=Math.ceil(q.count/4),at=ct%b.width,Et=Math.floor(ct/b.width),zt=rt,st=1;e.pixelStorei(i.UNPACK_SKIP_PIXELS,at),e.pixelStorei(i.UNPACK_SKIP_ROWS,Et),e.texSubImage2D(i.TEXTURE_2D,0,at,Et,zt,st,k,it,b.data)}A.clearUpdateRanges(),e.pixelStorei(i.UNPACK_ROW_LENGTH,Y),e.pixelStorei(i.UNPACK_SKIP_PIXELS,j),e.pixelStorei(i.UNPACK_SKIP_ROWS,lt)}}function Me(A,b,k){let it=i.TEXTURE_2D;(b.isDataArrayTexture||b.isCompressedArrayTexture)&&(it=i.TEXTURE_2D_ARRAY),b.isData3DTexture&&(it=i.TEXTURE_3D);let J=ie(A,b),ot=b.source;e.bindTexture(it,A.__webglTexture,i.TEXTURE0+k);let ut=n.get(ot);if(ot.version!==ut.__version||J===!0){if(e.activeTexture(i.TEXTURE0+k),(typeof ImageBitmap<"u"&&b.image instanceof ImageBitmap)===!1){let st=Xt.getPrimaries(Xt.workingColorSpace),At=b.colorSpace===xi?null:Xt.getPrimaries(b.colorSpace),kt=b.colorSpace===xi||st===At?i.NONE:i.BROWSER_DEFAULT_WEBGL;e.pixelStorei(i.UNPACK_FLIP_Y_WEBGL,b.flipY),e.pixelStorei(i.UNPACK_PREMULTIPLY_ALPHA_WEBGL,b.premultiplyAlpha),e.pixelStorei(i.UNPACK_COLORSPACE_CONVERSION_WEBGL,kt)}e.pixelStorei(i.UNPACK_ALIGNMENT,b.unpackAlignment);let j=_(b.image,!1,s.maxTextureSize);j=Pt(b,j);let lt=r.convert(b.format,b.colorSpace),R=r.convert(b.type),K=E(b.internalFormat,lt,R,b.normalized,b.colorSpace,b.isVideoTexture);te(it,b);let q,ct=b.mipmaps,rt=b.isVideoTexture!==!0,at=ut.__version===void 0||J===!0,Et=ot.dataReady,zt=w(b,j);if(b.isDepthTexture)K=v(b.format===vi,b.type),at&&(rt?e.texStorage2D(i.TEXTURE_2D,1,K,j.width,j.height):e.texImage2D(i.TEXTURE_2D,0,K,j.width,j.height,0,lt,R,null));else if(b.isDataTexture)if(ct.length>0){rt&&at&&e.texStorage2D(i.TEXTURE_2D,zt,K,ct[0].width,ct[0].height);for(let st=0,At=ct.length;st<At;st++)q=ct[st],rt?Et&&e.texSubImage2D(i.TEXTURE_2D,st,0,0,q.width,q.height,lt,R,q.data):e.texImage2D(i.TEXTURE_2D,st,K,q.width,q.height,0,lt,R,q.data);b.generateMipmaps=!1}else rt?(at&&e.texStorage2D(i.TEXTURE_2D,zt,K,j.width,j.height),Et&&Fe(b,j,lt,R)):e.texImage2D(i.TEXTURE_2D,0,K,j.width,j.height,0,lt,R,j.data);else if(b.isCompressedTexture)if(b.isCompressedArrayTexture){rt&&at&&e.texStorage3D(i.TEXTURE_2D_ARRAY,zt,K,ct[0].width,ct[0].height,j.depth);for(let st=0,At=ct.length;st<At;st++)if(q=ct[st],b.format!==_n)if(lt!==null)if(rt){if(Et)if(b.layerUpdates.size>0){let kt=ru(q.width,q.height,b.format,b.type);for(let mt of b.layerUpdates){let ee=q.data.subarray(mt*kt/q.data.BYTES_PER_ELEMENT,(mt+1)*kt/q.data.BYTES_PER_ELEMENT);e.compressedTexSubImage3D(i.TEXTURE_2D_ARRAY,st,0,0,mt,q.width,q.height,1,lt,ee)}}else e.compressedTexSubImage3D(i.TEXTURE_2D_ARRAY,st,0,0,0,q.width,q.height,j.depth,lt,q.data)}else e.compressedTexImage3D(i.TEXTURE_2D_ARRAY,st,K,q.width,q.height,j.depth,0,q.data,0,0);else Tt("WebGLRenderer: Attempt to load unsupported compressed texture format in .uploadTexture()");else rt?Et&&e.texSubImage3D(i.TEXTURE_2D_ARRAY,st,0,0,0,q.width,q.height,j.depth,lt,R,q.data):e.texImage3D(i.TEXTURE_2D_ARRAY,st,K,q.width,q.height,j.depth,0,lt,R,q.data);b.layerUpdates.size>0&&b.clearLayerUpdates()}else{rt&&at&&e.texStorage2D(i.TEXTURE_2D,zt,K,ct[0].width,ct[0].height);for(let st=0,At=ct.length;st<At;st++)q=ct[st],b.format!==_n?lt!==null?rt?Et&&e.compressedTexSubImage2D(i.TEXTURE_2D,st,0,0,q.width,q.height,lt,q.data):e.compressedTexImage2D(i.TEXTURE_2D,st,K,q.width,q.height,0,q.data):Tt("WebGLRenderer: Attempt to load unsupported compressed texture format in .uploadTexture()"):rt?Et&&e.texSubImage2D(i.TEXTURE_2D,st,0,0,q.width,q.height,lt,R,q.data):e.texImage2D(i.TEXTURE_2D,st,K,q.width,q.height,0,lt,R,q.data)}else if(b.isDataArrayTexture)if(rt){if(at&&e.texStorage3D(i.TEXTURE_2D_ARRAY,zt,K,j.width,j.height,j.depth),Et)if(b.layerUpdates.size>0){let st=ru(j.width,j.height,b.format,b.type);for(let At of b.layerUpdates){let kt=j.data.subarray(At*st/j.data.BYTES_PER_ELEMENT,(At+1)*st/j.data.BYTES_PER_ELEMENT);e.texSubImage3D(i.TEXTURE_2D_ARRAY,0,0,0,At,j.width,j.height,1,lt,R,kt)}b.clearLayerUpdates()}else e.texSubImage3D(i.TEXTURE_2D_ARRAY,0,0,0,0,j.width,j.height,j.depth,lt,R,j.data)}else e.texImage3D(i.TEXTURE_2D_ARRAY,0,K,j.width,j.height,j.depth,0,lt,R,j.data);else if(b.isData3DTexture)rt?(at&&e.texStorage3D(i.TEXTURE_3D,zt,K,j.width,j.height,j.depth),Et&&e.texSubImage3D(i.TEXTURE_3D,0,0,0,0,j.width,j.height,j.depth,lt,R,j.data)):e.texImage3D(i.TEXTURE_3D,0,K,j.width,j.height,j.depth,0,lt,R,j.data);else if(b.isFramebufferTexture){if(at)if(rt)e.texStorage2D(i.TEXTURE_2D,zt,K,j.width,j.height);else{let st=j.width,At=j.height;for(let kt=0;kt<zt;kt++)e.texImage2D(i.TEXTURE_2D,kt,K,st,At,0,lt,R,null),st>>=1,At>>=1}}else if(b.isHTMLTexture){if("texElementImage2D"in i){let st=i.canvas;if(st.hasAttribute("layoutsubtree")||st.setAttribute("layoutsubtree","true"),j.parentNode!==st){st.appendChild(j),d.add(b),st.onpaint=At=>{let kt=At.changedElements;for(let mt of d)kt.includes(mt.image)&&(mt.needsUpdate=!0)},st.requestPaint();return}if(i.texElementImage2D.length===3)i.texElementImage2D(i.TEXTURE_2D,i.RGBA8,j);else{let kt=i.RGBA,mt=i.RGBA,ee=i.UNSIGNED_BYTE;i.texElementImage2D(i.TEXTURE_2D,0,kt,mt,ee,j)}i.texParameteri(i.TEXTURE_2D,i.TEXTURE_MIN_FILTER,i.LINEAR),i.texParameteri(i.TEXTURE_2D,i.TEXTURE_WRAP_S,i.CLAMP_TO_EDGE),i.texParameteri(i.TEXTURE_2D,i.TEXTURE_WRAP_T,i.CLAMP_TO_EDGE)}}else if(ct.length>0){if(rt&&at){let st=Ut(ct[0]);e.texStorage2D(i.TEXTURE_2D,zt,K,st.width,st.height)}for(let st=0,At=ct.length;st<At;st++)q=ct[st],rt?Et&&e.texSubImage2D(i.TEXTURE_2D,st,0,0,lt,R,q):e.texImage2D(i.TEXTURE_2D,st,K,lt,R,q);b.generateMipmaps=!1}else if(rt){if(at){let st=Ut(j);e.texStorage2D(i.TEXTURE_2D,zt,K,st.width,st.height)}Et&&e.texSubImage2D(i.TEXTURE_2D,0,0,0,lt,R,j)}else e.texImage2D(i.TEXTURE_2D,0,K,lt,R,j);M(b)&&b.mipmapsAutoUpdate===!0&&y(it),ut.__version=ot.version,b.onUpdate&&b.onUpdate(b)}A.__version=b.version}function rn(A,b,k){if(b.image.length!==6)return;let it=ie(A,b),J=b.source;e.bindTexture(i.TEXTURE_CUBE_MAP,A.__webglTexture,i.TEXTURE0+k);let ot=n.get(J);if(J.version!==ot.__version||it===!0){e.activeTexture(i.TEXTURE0+k);let ut=Xt.getPrimaries(Xt.workingColorSpace),Y=b.colorSpace===xi?null:Xt.getPrimaries(b.colorSpace),j=b.colorSpace===xi||ut===Y?i.NONE:i.BROWSER_DEFAULT_WEBGL;e.pixelStorei(i.UNPACK_FLIP_Y_WEBGL,b.flipY),e.pixelStorei(i.UNPACK_PREMULTIPLY_ALPHA_WEBGL,b.premultiplyAlpha),e.pixelStorei(i.UNPACK_ALIGNMENT,b.unpackAlignment),e.pixelStorei(i.UNPACK_COLORSPACE_CONVERSION_WEBGL,j);let lt=b.isCompressedTexture||b.image[0].isCompressedTexture,R=b.image[0]&&b.image[0].isDataTexture,K=[];for(let mt=0;mt<6;mt++)!lt&&!R?K[mt]=_(b.image[mt],!0,s.maxCubemapSize):K[mt]=R?b.image[mt].image:b.image[mt],K[mt]=Pt(b,K[mt]);let q=K[0],ct=r.convert(b.format,b.colorSpace),rt=r.convert(b.type),at=E(b.internalFormat,ct,rt,b.normalized,b.colorSpace),Et=b.isVideoTexture!==!0,zt=ot.__version===void 0||it===!0,st=J.dataReady,At=w(b,q);te(i.TEXTURE_CUBE_MAP,b);let kt;if(b.isDepthTexture){if(at=v(b.format===vi,b.type),zt)if(Et)e.texStorage2D(i.TEXTURE_CUBE_MAP,1,at,q.width,q.height);else for(let mt=0;mt<6;mt++)e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,0,at,q.width,q.height,0,ct,rt,null)}else if(lt){Et&&zt&&e.texStorage2D(i.TEXTURE_CUBE_MAP,At,at,q.width,q.height);for(let mt=0;mt<6;mt++){kt=K[mt].mipmaps;for(let ee=0;ee<kt.length;ee++){let Ie=kt[ee];b.format!==_n?ct!==null?Et?st&&e.compressedTexSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee,0,0,Ie.width,Ie.height,ct,Ie.data):e.compressedTexImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee,at,Ie.width,Ie.height,0,Ie.data):Tt("WebGLRenderer: Attempt to load unsupported compressed texture format in .setTextureCube()"):Et?st&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee,0,0,Ie.width,Ie.height,ct,rt,Ie.data):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee,at,Ie.width,Ie.height,0,ct,rt,Ie.data)}}}else{if(kt=b.mipmaps,Et&&zt){kt.length>0&&At++;let mt=Ut(K[0]);e.texStorage2D(i.TEXTURE_CUBE_MAP,At,at,mt.width,mt.height)}for(let mt=0;mt<6;mt++)if(R){Et?st&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,0,0,0,K[mt].width,K[mt].height,ct,rt,K[mt].data):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,0,at,K[mt].width,K[mt].height,0,ct,rt,K[mt].data);for(let ee=0;ee<kt.length;ee++){let Ei=kt[ee].image[mt].image;Et?st&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee+1,0,0,Ei.width,Ei.height,ct,rt,Ei.data):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee+1,at,Ei.width,Ei.height,0,ct,rt,Ei.data)}}else{Et?st&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,0,0,0,ct,rt,K[mt]):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,0,at,ct,rt,K[mt]);for(let ee=0;ee<kt.length;ee++){let Ie=kt[ee];Et?st&&e.texSubImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee+1,0,0,ct,rt,Ie.image[mt]):e.texImage2D(i.TEXTURE_CUBE_MAP_POSITIVE_X+mt,ee+1,at,ct,rt,Ie.image[mt])}}}M(b)&&b.mipmapsAutoUpdate===!0&&y(i.TEXTURE_CUBE_MAP),ot.__version=J.version,b.onUpdate&&b.onUpdate(b)}A.__version=b.version}function de(A,b,k,it,J,ot){let ut=r.convert(k.format,k.colorSpace),Y=r.convert(k.type),j=E(k.internalFormat,ut,Y,k.normalized,k.colorSpace),lt=n.get(b),R=n.get(k);if(R.__renderTarget=b,!lt.__hasExternalTextures){let K=Math.max(1,b.width>>ot),q=Math.max(1,b.height>>ot);J===i.TEXTURE_3D||J===i.TEXTURE_2D_ARRAY?e.texImage3D(J,ot,j,K,q,b.depth,0,ut,Y,null):e.texImage2D(J,ot,j,K,q,0,ut,Y,null)}e.bindFramebuffer(i.FRAMEBUFFER,A),pt(b)?a.framebufferTexture2DMultisampleEXT(i.FRAMEBUFFER,it,J,R.__webglTexture,0,ce(b)):(J===i.TEXTURE_2D||J>=i.TEXTURE_CUBE_MAP_POSITIVE_X&&J<=i.TEXTURE_CUBE_MAP_NEGATIVE_Z)&&i.framebufferTexture2D(i.FRAMEBUFFER,it,J,R.__webglTexture,ot),e.bindFramebuffer(i.FRAMEBUFFER,null)}function qn(A,b,k){if(i.bindRenderbuffer(i.RENDERBUFFER,A),b.depthBuffer){let it=b.depthTexture,J=it&&it.isDepthTexture?it.type:null,ot=v(b.stencilBuffer,J),ut=b.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT;pt(b)?a.renderbufferStorageMultisampleEXT(i.RENDERBUFFER,ce(b),ot,b.width,b.height):k?i.renderbufferStorageMultisample(i.RENDERBUFFER,ce(b),ot,b.width,b.height):i.renderbufferStorage(i.RENDERBUFFER,ot,b.width,b.height),i.framebufferRenderbuffer(i.FRAMEBUFFER,ut,i.RENDERBUFFER,A)}else{let it=b.textures;for(let J=0;J<it.length;J++){let ot=it[J],ut=r.convert(ot.format,ot.colorSpace),Y=r.convert(ot.type),j=E(ot.internalFormat,ut,Y,ot.normalized,ot.colorSpace);pt(b)?a.renderbufferStorageMultisampleEXT(i.RENDERBUFFER,ce(b),j,b.width,b.height):k?i.renderbufferStorageMultisample(i.RENDERBUFFER,ce(b),j,b.width,b.height):i.renderbufferStorage(i.RENDERBUFFER,j,b.width,b.height)}}i.bindRenderbuffer(i.RENDERBUFFER,null)}function Pe(A,b,k){let it=b.isWebGLCubeRenderTarget===!0;if(e.bindFramebuffer(i.FRAMEBUFFER,A),!(b.depthTexture&&b.depthTexture.isDepthTexture))throw new Error("THREE.WebGLTextures: renderTarget.depthTexture must be an instance of THREE.DepthTexture.");let J=n.get(b.depthTexture);J.__renderTarget=b;let ot=it?b.depthTexture.image[0]:b.depthTexture.image;(!J.__webglTexture||ot.width!==b.width||ot.height!==b.height)&&(ot.width=b.width,ot.height=b.height,b.depthTexture.needsUpdate=!0),it?vt(b.depthTexture,0):gt(b.depthTexture,0);let ut=J.__webglTexture,Y=ce(b),j=it?i.TEXTURE_CUBE_MAP_POSITIVE_X+k:i.TEXTURE_2D,lt=b.depthTexture.format===vi?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT;if(b.depthTexture.format===di)pt(b)?a.framebufferTexture2DMultisampleEXT(i.FRAMEBUFFER,lt,j,ut,0,Y):i.framebufferTexture2D(i.FRAMEBUFFER,lt,j,ut,0);else if(b.depthTexture.format===vi)pt(b)?a.framebufferTexture2DMultisampleEXT(i.FRAMEBUFFER,lt,j,ut,0,Y):i.framebufferTexture2D(i.FRAMEBUFFER,lt,j,ut,0);else throw new Error("THREE.WebGLTextures: Unknown depthTexture format.")}function Sn(A){let b=n.get(A),k=A.isWebGLCubeRenderTarget===!0;if(b.__boundDepthTexture!==A.depthTexture){let it=A.depthTexture;if(b.__depthDisposeCallback&&b.__depthDisposeCallback(),it){let J=()=>{delete b.__boundDepthTexture,delete b.__depthDisposeCallback,it.removeEventListener("dispose",J)};it.addEventListener("dispose",J),b.__depthDisposeCallback=J}b.__boundDepthTexture=it}if(A.depthTexture&&!b.__autoAllocateDepthBuffer)if(k)for(let it=0;it<6;it++)Pe(b.__webglFramebuffer[it],A,it);else A.texture.mipmaps.length>0?Pe(b.__webglFramebuffer[0],A,0):Pe(b.__webglFramebuffer,A,0);else if(k){b.__webglDepthbuffer=[];for(let it=0;it<6;it++)if(e.bindFramebuffer(i.FRAMEBUFFER,b.__webglFramebuffer[it]),b.__webglDepthbuffer[it]===void 0)b.__webglDepthbuffer[it]=i.createRenderbuffer(),qn(b.__webglDepthbuffer[it],A,!1);else{let J=A.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT,ot=b.__webglDepthbuffer[it];i.bindRenderbuffer(i.RENDERBUFFER,ot),i.framebufferRenderbuffer(i.FRAMEBUFFER,J,i.RENDERBUFFER,ot)}}else if(A.texture.mipmaps.length>0?e.bindFramebuffer(i.FRAMEBUFFER,b.__webglFramebuffer[0]):e.bindFramebuffer(i.FRAMEBUFFER,b.__webglFramebuffer),b.__webglDepthbuffer===void 0)b.__webglDepthbuffer=i.createRenderbuffer(),qn(b.__webglDepthbuffer,A,!1);else{let J=A.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT,ot=b.__webglDepthbuffer;i.bindRenderbuffer(i.RENDERBUFFER,ot),i.framebufferRenderbuffer(i.FRAMEBUFFER,J,i.RENDERBUFFER,ot)}e.bindFramebuffer(i.FRAMEBUFFER,null)}function Mn(A,b,k){let it=n.get(A);b!==void 0&&de(it.__webglFramebuffer,A,A.texture,i.COLOR_ATTACHMENT0,i.TEXTURE_2D,0),k!==void 0&&Sn(A)}function wn(A){let b=A.texture,k=n.get(A),it=n.get(b);A.addEventListener("dispose",O),F(A);let J=A.textures,ot=A.isWebGLCubeRenderTarget===!0,ut=J.length>1;if(ut||(it.__webglTexture===void 0&&(it.__webglTexture=i.createTexture()),it.__version=b.version,o.memory.textures++),ot){k.__webglFramebuffer=[];for(let Y=0;Y<6;Y++)if(b.mipmaps.length>0){k.__webglFramebuffer[Y]=[];for(let j=0;j<b.mipmaps.length;j++)k.__webglFramebuffer[Y][j]=i.createFramebuffer()}else k.__webglFramebuffer[Y]=i.createFramebuffer()}else{if(b.mipmaps.length>0){k.__webglFramebuffer=[];for(let Y=0;Y<b.mipmaps.length;Y++)k.__webglFramebuffer[Y]=i.createFramebuffer()}else k.__webglFramebuffer=i.createFramebuffer();if(ut)for(let Y=0,j=J.length;Y<j;Y++){let lt=n.get(J[Y]);lt.__webglTexture===void 0&&(lt.__webglTexture=i.createTexture(),o.memory.textures++)}if(A.samples>0&&pt(A)===!1){k.__webglMultisampledFramebuffer=i.createFramebuffer(),k.__webglColorRenderbuffer=[],e.bindFramebuffer(i.FRAMEBUFFER,k.__webglMultisampledFramebuffer);for(let Y=0;Y<J.length;Y++){let j=J[Y];k.__webglColorRenderbuffer[Y]=i.createRenderbuffer(),i.bindRenderbuffer(i.RENDERBUFFER,k.__webglColorRenderbuffer[Y]);let lt=r.convert(j.format,j.colorSpace),R=r.convert(j.type),K=E(j.internalFormat,lt,R,j.normalized,j.colorSpace,A.isXRRenderTarget===!0),q=ce(A);i.renderbufferStorageMultisample(i.RENDERBUFFER,q,K,A.width,A.height),i.framebufferRenderbuffer(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+Y,i.RENDERBUFFER,k.__webglColorRenderbuffer[Y])}i.bindRenderbuffer(i.RENDERBUFFER,null),A.depthBuffer&&(k.__webglDepthRenderbuffer=i.createRenderbuffer(),qn(k.__webglDepthRenderbuffer,A,!0)),e.bindFramebuffer(i.FRAMEBUFFER,null)}}if(ot){e.bindTexture(i.TEXTURE_CUBE_MAP,it.__webglTexture),te(i.TEXTURE_CUBE_MAP,b);for(let Y=0;Y<6;Y++)if(b.mipmaps.length>0)for(let j=0;j<b.mipmaps.length;j++)de(k.__webglFramebuffer[Y][j],A,b,i.COLOR_ATTACHMENT0,i.TEXTURE_CUBE_MAP_POSITIVE_X+Y,j);else de(k.__webglFramebuffer[Y],A,b,i.COLOR_ATTACHMENT0,i.TEXTURE_CUBE_MAP_POSITIVE_X+Y,0);M(b)?y(i.TEXTURE_CUBE_MAP):b.mipmaps.length>0&&i.texParameteri(i.TEXTURE_CUBE_MAP,i.TEXTURE_MAX_LEVEL,b.mipmaps.length-1),e.unbindTexture()}else if(ut){for(let Y=0,j=J.length;Y<j;Y++){let lt=J[Y],R=n.get(lt),K=i.TEXTURE_2D;(A.isWebGL3DRenderTarget||A.isWebGLArrayRenderTarget)&&(K=A.isWebGL3DRenderTarget?i.TEXTURE_3D:i.TEXTURE_2D_ARRAY),e.bindTexture(K,R.__webglTexture),te(K,lt),de(k.__webglFramebuffer,A,lt,i.COLOR_ATTACHMENT0+Y,K,0),M(lt)&&y(K)}e.unbindTexture()}else{let Y=i.TEXTURE_2D;if((A.isWebGL3DRenderTarget||A.isWebGLArrayRenderTarget)&&(Y=A.isWebGL3DRenderTarget?i.TEXTURE_3D:i.TEXTURE_2D_ARRAY),e.bindTexture(Y,it.__webglTexture),te(Y,b),b.mipmaps.length>0)for(let j=0;j<b.mipmaps.length;j++)de(k.__webglFramebuffer[j],A,b,i.COLOR_ATTACHMENT0,Y,j);else de(k.__webglFramebuffer,A,b,i.COLOR_ATTACHMENT0,Y,0);M(b)?y(Y):b.mipmaps.length>0&&i.texParameteri(Y,i.TEXTURE_MAX_LEVEL,b.mipmaps.length-1),e.unbindTexture()}A.depthBuffer&&Sn(A)}function U(A){let b=A.textures;for(let k=0,it=b.length;k<it;k++){let J=b[k];if(M(J)&&J.mipmapsAutoUpdate===!0){let ot=T(A),ut=n.get(J).__webglTexture;e.bindTexture(ot,ut),y(ot),e.unbindTexture()}}}let En=[];function le(A){if(A.samples>0){if(pt(A)===!1){let b=A.textures,k=A.width,it=A.height,J=i.COLOR_BUFFER_BIT,ot=A.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT,ut=n.get(A),Y=b.length>1;if(Y)for(let lt=0;lt<b.length;lt++)e.bindFramebuffer(i.FRAMEBUFFER,ut.__webglMultisampledFramebuffer),i.framebufferRenderbuffer(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+lt,i.RENDERBUFFER,null),e.bindFramebuffer(i.FRAMEBUFFER,ut.__webglFramebuffer),i.framebufferTexture2D(i.DRAW_FRAMEBUFFER,i.COLOR_ATTACHMENT0+lt,i.TEXTURE_2D,null,0);e.bindFramebuffer(i.READ_FRAMEBUFFER,ut.__webglMultisampledFramebuffer),A.texture.mipmaps.length>0?e.bindFramebuffer(i.DRAW_FRAMEBUFFER,ut.__webglFramebuffer[0]):e.bindFramebuffer(i.DRAW_FRAMEBUFFER,ut.__webglFramebuffer);for(let lt=0;lt<b.length;lt++){if(A.resolveDepthBuffer&&(A.depthBuffer&&(J|=i.DEPTH_BUFFER_BIT),A.stencilBuffer&&A.resolveStencilBuffer&&(J|=i.STENCIL_BUFFER_BIT)),Y){i.framebufferRenderbuffer(i.READ_FRAMEBUFFER,i.COLOR_ATTACHMENT0,i.RENDERBUFFER,ut.__webglColorRenderbuffer[lt]);let R=n.get(b[lt]).__webglTexture;i.framebufferTexture2D(i.DRAW_FRAMEBUFFER,i.COLOR_ATTACHMENT0,i.TEXTURE_2D,R,0)}i.blitFramebuffer(0,0,k,it,0,0,k,it,J,i.NEAREST),l===!0&&(En.length=0,En.push(i.COLOR_ATTACHMENT0+lt),A.depthBuffer&&A.storeMultisampledDepthBuffer===!1&&En.push(ot),i.invalidateFramebuffer(i.READ_FRAMEBUFFER,En))}if(e.bindFramebuffer(i.READ_FRAMEBUFFER,null),e.bindFramebuffer(i.DRAW_FRAMEBUFFER,null),Y)for(let lt=0;lt<b.length;lt++){e.bindFramebuffer(i.FRAMEBUFFER,ut.__webglMultisampledFramebuffer),i.framebufferRenderbuffer(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+lt,i.RENDERBUFFER,ut.__webglColorRenderbuffer[lt]);let R=n.get(b[lt]).__webglTexture;e.bindFramebuffer(i.FRAMEBUFFER,ut.__webglFramebuffer),i.framebufferTexture2D(i.DRAW_FRAMEBUFFER,i.COLOR_ATTACHMENT0+lt,i.TEXTURE_2D,R,0)}e.bindFramebuffer(i.DRAW_FRAMEBUFFER,ut.__webglMultisampledFramebuffer)}else if(A.depthBuffer&&A.storeMultisampledDepthBuffer===!1&&l){let b=A.stencilBuffer?i.DEPTH_STENCIL_ATTACHMENT:i.DEPTH_ATTACHMENT;i.invalidateFramebuffer(i.DRAW_FRAMEBUFFER,[b])}}}function ce(A){return Math.min(s.maxSamples,A.samples)}function pt(A){let b=n.get(A);return A.samples>0&&t.has("WEBGL_multisampled_render_to_texture")===!0&&b.__useRenderToTexture!==!1}function we(A){let b=o.render.frame;h.get(A)!==b&&(h.set(A,b),A.update())}function Pt(A,b){let k=A.colorSpace,it=A.format,J=A.type;return A.isCompressedTexture===!0||A.isVideoTexture===!0||k!==mr&&k!==xi&&(Xt.getTransfer(k)===Jt?(it!==_n||J!==vn)&&Tt("WebGLTextures: sRGB encoded textures have to use RGBAFormat and UnsignedByteType."):Lt("WebGLTextures: Unsupported texture color space:",k)),b}function Ut(A){return typeof HTMLImageElement<"u"&&A instanceof HTMLImageElement?(c.width=A.naturalWidth||A.width,c.height=A.naturalHeight||A.height):typeof VideoFrame<"u"&&A instanceof VideoFrame?(c.width=A.displayWidth,c.height=A.displayHeight):(c.width=A.width,c.height=A.height),c}this.allocateTextureUnit=Dt,this.resetTextureUnits=Q,this.getTextureUnits=et,this.setTextureUnits=yt,this.setTexture2D=gt,this.setTexture2DArray=bt,this.setTexture3D=Rt,this.setTextureCube=vt,this.rebindTextures=Mn,this.setupRenderTarget=wn,this.updateRenderTargetMipmap=U,this.updateMultisampleRenderTarget=le,this.setupDepthRenderbuffer=Sn,this.setupFrameBufferTexture=de,this.useMultisampledRTT=pt,this.dispose=H}function SS(i,t){function e(n,s=xi){let r,o=Xt.getTransfer(s);if(n===vn)return i.UNSIGNED_BYTE;if(n===Fa)return i.UNSIGNED_SHORT_4_4_4_4;if(n===Oa)return i.UNSIGNED_SHORT_5_5_5_1;if(n===Bh)return i.UNSIGNED_INT_5_9_9_9_REV;if(n===kh)return i.UNSIGNED_INT_10F_11F_11F_REV;if(n===Fh)return i.BYTE;if(n===Oh)return i.SHORT;if(n===Vs)return i.UNSIGNED_SHORT;if(n===Ua)return i.INT;if(n===Hn)return i.UNSIGNED_INT;if(n===Gn)return i.FLOAT;if(n===xn)return i.HALF_FLOAT;if(n===zh)return i.ALPHA;if(n===Hh)return i.RGB;if(n===_n)return i.RGBA;if(n===di)return i.DEPTH_COMPONENT;if(n===vi)return i.DEPTH_STENCIL;if(n===Gh)return i.RED;if(n===Ba)return i.RED_INTEGER;if(n===zi)return i.RG;if(n===ka)return i.RG_INTEGER;if(n===za)return i.RGBA_INTEGER;if(n===Hr||n===Gr||n===Vr||n===Wr)if(o===Jt)if(r=t.get("WEBGL_compressed_texture_s3tc_srgb"),r!==null){if(n===Hr)return r.COMPRESSED_SRGB_S3TC_DXT1_EXT;if(n===Gr)return r.COMPRESSED_SRGB_ALPHA_S3TC_DXT1_EXT;if(n===Vr)return r.COMPRESSED_SRGB_ALPHA_S3TC_DXT3_EXT;if(n===Wr)return r.COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT}else return null;else if(r=t.get("WEBGL_compressed_texture_s3tc"),r!==null){if(n===Hr)return r.COMPRESSED_RGB_S3TC_DXT1_EXT;if(n===Gr)return r.COMPRESSED_RGBA_S3TC_DXT1_EXT;if(n===Vr)return r.COMPRESSED_RGBA_S3TC_DXT3_EXT;if(n===Wr)return r.COMPRESSED_RGBA_S3TC_DXT5_EXT}else return null;if(n===Ha||n===Ga||n===Va||n===Wa)if(r=t.get("WEBGL_compressed_texture_pvrtc"),r!==null){if(n===Ha)return r.COMPRESSED_RGB_PVRTC_4BPPV1_IMG;if(n===Ga)return r.COMPRESSED_RGB_PVRTC_2BPPV1_IMG;if(n===Va)return r.COMPRESSED_RGBA_PVRTC_4BPPV1_IMG;if(n===Wa)return r.COMPRESSED_RGBA_PVRTC_2BPPV1_IMG}else return null;if(n===$a||n===Xa||n===qa||n===Ya||n===ja||n===$r||n===Za)if(r=t.get("WEBGL_compressed_texture_etc"),r!==null){if(n===$a||n===Xa)return o===Jt?r.COMPRESSED_SRGB8_ETC2:r.COMPRESSED_RGB8_ETC2;if(n===qa)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ETC2_EAC:r.COMPRESSED_RGBA8_ETC2_EAC;if(n===Ya)return r.COMPRESSED_R11_EAC;if(n===ja)return r.COMPRESSED_SIGNED_R11_EAC;if(n===$r)return r.COMPRESSED_RG11_EAC;if(n===Za)return r.COMPRESSED_SIGNED_RG11_EAC}else return null;if(n===Ka||n===Ja||n===Qa||n===tl||n===el||n===nl||n===il||n===sl||n===rl||n===ol||n===al||n===ll||n===cl||n===hl)if(r=t.get("WEBGL_compressed_texture_astc"),r!==null){if(n===Ka)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_4x4_KHR:r.COMPRESSED_RGBA_ASTC_4x4_KHR;if(n===Ja)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_5x4_KHR:r.COMPRESSED_RGBA_ASTC_5x4_KHR;if(n===Qa)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_5x5_KHR:r.COMPRESSED_RGBA_ASTC_5x5_KHR;if(n===tl)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_6x5_KHR:r.COMPRESSED_RGBA_ASTC_6x5_KHR;if(n===el)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_6x6_KHR:r.COMPRESSED_RGBA_ASTC_6x6_KHR;if(n===nl)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_8x5_KHR:r.COMPRESSED_RGBA_ASTC_8x5_KHR;if(n===il)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_8x6_KHR:r.COMPRESSED_RGBA_ASTC_8x6_KHR;if(n===sl)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_8x8_KHR:r.COMPRESSED_RGBA_ASTC_8x8_KHR;if(n===rl)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x5_KHR:r.COMPRESSED_RGBA_ASTC_10x5_KHR;if(n===ol)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x6_KHR:r.COMPRESSED_RGBA_ASTC_10x6_KHR;if(n===al)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x8_KHR:r.COMPRESSED_RGBA_ASTC_10x8_KHR;if(n===ll)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_10x10_KHR:r.COMPRESSED_RGBA_ASTC_10x10_KHR;if(n===cl)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_12x10_KHR:r.COMPRESSED_RGBA_ASTC_12x10_KHR;if(n===hl)return o===Jt?r.COMPRESSED_SRGB8_ALPHA8_ASTC_12x12_KHR:r.COMPRESSED_RGBA_ASTC_12x12_KHR}else return null;if(n===ul||n===dl||n===fl)if(r=t.get("EXT_texture_compression_bptc"),r!==null){if(n===ul)return o===Jt?r.COMPRESSED_SRGB_ALPHA_BPTC_UNORM_EXT:r.COMPRESSED_RGBA_BPTC_UNORM_EXT;if(n===dl)return r.COMPRESSED_RGB_BPTC_SIGNED_FLOAT_EXT;if(n===fl)return r.COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT_EXT}else return null;if(n===pl||n===ml||n===Xr||n===gl)if(r=t.get("EXT_texture_compression_rgtc"),r!==null){if(n===pl)return r.COMPRESSED_RED_RGTC1_EXT;if(n===ml)return r.COMPRESSED_SIGNED_RED_RGTC1_EXT;if(n===Xr)return r.COMPRESSED_RED_GREEN_RGTC2_EXT;if(n===gl)return r.COMPRESSED_SIGNED_RED_GREEN_RGTC2_EXT}else return null;return n===os?i.UNSIGNED_INT_24_8:i[n]!==void 0?i[n]:null}return{convert:e}}var MS=`
void main() {

	gl_Position = vec4( position, 1.0 );

}`,wS=`
uniform sampler2DArray depthColor;
uniform float depthWidth;
uniform float depthHeight;

void main() {

	vec2 coord = vec2( gl_FragCoord.x / depthWidth, gl_FragCoord.y / depthHeight );

	if ( coord.x >= 1.0 ) {

		gl_FragDepth = texture( depthColor, vec3( coord.x - 1.0, coord.y, 1 ) ).r;

	} else {

		gl_FragDepth = texture( depthColor, vec3( coord.x, coord.y, 0 ) ).r;

	}

}`,pu=class{constructor(){this.texture=null,this.mesh=null,this.depthNear=0,this.depthFar=0}init(t,e){if(this.texture===null){let n=new Ar(t.texture);(t.depthNear!==e.depthNear||t.depthFar!==e.depthFar)&&(this.depthNear=t.depthNear,this.depthFar=t.depthFar),this.texture=n}}getMesh(t){if(this.texture!==null&&this.mesh===null){let e=t.cameras[0].viewport,n=new Ln({vertexShader:MS,fragmentShader:wS,uniforms:{depthColor:{value:this.texture},depthWidth:{value:e.z},depthHeight:{value:e.w}}});this.mesh=new me(new Ir(20,20),n)}return this.mesh}reset(){this.texture=null,this.mesh=null}getDepthTexture(){return this.texture}},mu=class extends On{constructor(t,e){super();let n=this,s=null,r=1,o=null,a="local-floor",l=1,c=null,h=null,d=null,u=null,f=null,g=null,x=typeof XRWebGLBinding<"u",p=new pu,m={},_=e.getContextAttributes(),M=null,y=null,T=[],E=[],v=new Ct,w=null,F=null,D=new tn;D.viewport=new ne;let N=new tn;N.viewport=new ne;let O=[D,N],V=new Ia,C=null,H=null;this.cameraAutoUpdate=!0,this.enabled=!1,this.isPresenting=!1,this.getController=function(Z){let gt=T[Z];return gt===void 0&&(gt=new Ds,T[Z]=gt),gt.getTargetRaySpace()},this.getControllerGrip=function(Z){let gt=T[Z];return gt===void 0&&(gt=new Ds,T[Z]=gt),gt.getGripSpace()},this.getHand=function(Z){let gt=T[Z];return gt===void 0&&(gt=new Ds,T[Z]=gt),gt.getHandSpace()};function X(Z){let gt=E.indexOf(Z.inputSource);if(gt===-1)return;let bt=T[gt];bt!==void 0&&(bt.update(Z.inputSource,Z.frame,c||o),bt.dispatchEvent({type:Z.type,data:Z.inputSource}))}function G(){s.removeEventListener("select",X),s.removeEventListener("selectstart",X),s.removeEventListener("selectend",X),s.removeEventListener("squeeze",X),s.removeEventListener("squeezestart",X),s.removeEventListener("squeezeend",X),s.removeEventListener("end",G),s.removeEventListener("inputsourceschange",nt);for(let Z=0;Z<T.length;Z++){let gt=E[Z];gt!==null&&(E[Z]=null,T[Z].disconnect(gt))}C=null,H=null,p.reset();for(let Z in m)delete m[Z];if(t.setRenderTarget(M),f=null,u=null,d=null,s=null,y=null,Dt.stop(),n.isPresenting=!1,t.setPixelRatio(w),t.setSize(v.width,v.height,!1),F!==null){let Z=F.camera;Z.fov=F.fov,Z.zoom=F.zoom,Z.updateProjectionMatrix(),F=null}n.dispatchEvent({type:"sessionend"})}this.setFramebufferScaleFactor=function(Z){r=Z,n.isPresenting===!0&&Tt("WebXRManager: Cannot change framebuffer scale while presenting.")},this.setReferenceSpaceType=function(Z){a=Z,n.isPresenting===!0&&Tt("WebXRManager: Cannot change reference space type while presenting.")},this.getReferenceSpace=function(){return c||o},this.setReferenceSpace=function(Z){c=Z},this.getBaseLayer=function(){return u!==null?u:f},this.getBinding=function(){return d===null&&x&&(d=new XRWebGLBinding(s,e)),d},this.getFrame=function(){return g},this.getSession=function(){return s},this.setSession=async function(Z){if(s=Z,s!==null){if(M=t.getRenderTarget(),s.addEventListener("select",X),s.addEventListener("selectstart",X),s.addEventListener("selectend",X),s.addEventListener("squeeze",X),s.addEventListener("squeezestart",X),s.addEventListener("squeezeend",X),s.addEventListener("end",G),s.addEventListener("inputsourceschange",nt),_.xrCompatible!==!0&&await e.makeXRCompatible(),w=t.getPixelRatio(),t.getSize(v),x&&"createProjectionLayer"in XRWebGLBinding.prototype){let bt=null,Rt=null,vt=null;_.depth&&(vt=_.stencil?e.DEPTH24_STENCIL8:e.DEPTH_COMPONENT24,bt=_.stencil?vi:di,Rt=_.stencil?os:Hn);let Bt={colorFormat:e.RGBA8,depthFormat:vt,scaleFactor:r};d=this.getBinding(),u=d.createProjectionLayer(Bt),s.updateRenderState({layers:[u]}),t.setPixelRatio(1),t.setSize(u.textureWidth,u.textureHeight,!1),y=new pn(u.textureWidth,u.textureHeight,{format:_n,type:vn,depthTexture:new mi(u.textureWidth,u.textureHeight,Rt,void 0,void 0,void 0,void 0,void 0,void 0,bt),stencilBuffer:_.stencil,colorSpace:t.outputColorSpace,samples:_.antialias?4:0,resolveDepthBuffer:u.ignoreDepthValues===!1,resolveStencilBuffer:u.ignoreDepthValues===!1,storeMultisampledDepthBuffer:u.ignoreDepthValues===!1,storeMultisampledStencilBuffer:u.ignoreDepthValues===!1})}else{let bt={antialias:_.antialias,alpha:!0,depth:_.depth,stencil:_.stencil,framebufferScaleFactor:r};f=new XRWebGLLayer(s,e,bt),s.updateRenderState({baseLayer:f}),t.setPixelRatio(1),t.setSize(f.framebufferWidth,f.framebufferHeight,!1),y=new pn(f.framebufferWidth,f.framebufferHeight,{format:_n,type:vn,colorSpace:t.outputColorSpace,stencilBuffer:_.stencil,resolveDepthBuffer:f.ignoreDepthValues===!1,resolveStencilBuffer:f.ignoreDepthValues===!1,storeMultisampledDepthBuffer:f.ignoreDepthValues===!1,storeMultisampledStencilBuffer:f.ignoreDepthValues===!1})}y.isXRRenderTarget=!0,this.setFoveation(l),c=null,o=await s.requestReferenceSpace(a),Dt.setContext(s),Dt.start(),n.isPresenting=!0,n.dispatchEvent({type:"sessionstart"})}},this.getEnvironmentBlendMode=function(){if(s!==null)return s.environmentBlendMode},this.getDepthTexture=function(){return p.getDepthTexture()};function nt(Z){for(let gt=0;gt<Z.removed.length;gt++){let bt=Z.removed[gt],Rt=E.indexOf(bt);Rt>=0&&(E[Rt]=null,T[Rt].disconnect(bt))}for(let gt=0;gt<Z.added.length;gt++){let bt=Z.added[gt],Rt=E.indexOf(bt);if(Rt===-1){for(let Bt=0;Bt<T.length;Bt++)if(Bt>=E.length){E.push(bt),Rt=Bt;break}else if(E[Bt]===null){E[Bt]=bt,Rt=Bt;break}if(Rt===-1)break}let vt=T[Rt];vt&&vt.connect(bt)}}function $(Z,gt){gt===null?Z.matrixWorld.copy(Z.matrix):Z.matrixWorld.multiplyMatrices(gt.matrixWorld,Z.matrix),Z.matrixWorldInverse.copy(Z.matrixWorld).invert()}this.updateCamera=function(Z){if(s===null)return;let gt=Z.near,bt=Z.far;p.texture!==null&&(p.depthNear>0&&(gt=p.depthNear),p.depthFar>0&&(bt=p.depthFar)),V.near=N.near=D.near=gt,V.far=N.far=D.far=bt,(C!==V.near||H!==V.far)&&(s.updateRenderState({depthNear:V.near,depthFar:V.far}),C=V.near,H=V.far),V.layers.mask=Z.layers.mask|6,D.layers.mask=V.layers.mask&-5,N.layers.mask=V.layers.mask&-3;let Rt=Z.parent,vt=V.cameras;$(V,Rt);for(let Bt=0;Bt<vt.length;Bt++)$(vt[Bt],Rt);V.projectionMatrix.copy(D.projectionMatrix),V.projectionMatrixInverse.copy(D.projectionMatrixInverse),F===null&&Z.isPerspectiveCamera&&(F={camera:Z,fov:Z.fov,zoom:Z.zoom}),Q(Z,V,Rt)};function Q(Z,gt,bt){bt===null?Z.matrix.copy(gt.matrixWorld):(Z.matrix.copy(bt.matrixWorld),Z.matrix.invert(),Z.matrix.multiply(gt.matrixWorld)),Z.matrix.decompose(Z.position,Z.quaternion,Z.scale),Z.updateMatrixWorld(!0),Z.projectionMatrix.copy(gt.projectionMatrix),Z.projectionMatrixInverse.copy(gt.projectionMatrixInverse),Z.isPerspectiveCamera&&(Z.fov=Ps*2*Math.atan(1/Z.projectionMatrix.elements[5]),Z.zoom=1)}this.getCamera=function(){return V},this.getFoveation=function(){if(!(u===null&&f===null))return l},this.setFoveation=function(Z){l=Z,u!==null&&(u.fixedFoveation=Z),f!==null&&f.fixedFoveation!==void 0&&(f.fixedFoveation=Z)},this.hasDepthSensing=function(){return p.texture!==null},this.getDepthSensingMesh=function(){return p.getMesh(V)},this.getCameraTexture=function(Z){return m[Z]};let et=null;function yt(Z,gt){if(h=gt.getViewerPose(c||o),g=gt,h!==null){let bt=h.views;f!==null&&(t.setRenderTargetFramebuffer(y,f.framebuffer),t.setRenderTarget(y));let Rt=!1;bt.length!==V.cameras.length&&(V.cameras.length=0,Rt=!0);for(let It=0;It<bt.length;It++){let te=bt[It],ie=null;if(f!==null)ie=f.getViewport(te);else{let Fe=d.getViewSubImage(u,te);ie=Fe.viewport,It===0&&(t.setRenderTargetTextures(y,Fe.colorTexture,Fe.depthStencilTexture),t.setRenderTarget(y))}let Vt=O[It];Vt===void 0&&(Vt=new tn,Vt.layers.enable(It),Vt.viewport=new ne,O[It]=Vt),Vt.matrix.fromArray(te.transform.matrix),Vt.matrix.decompose(Vt.position,Vt.quaternion,Vt.scale),Vt.projectionMatrix.fromArray(te.projectionMatrix),Vt.projectionMatrixInverse.copy(Vt.projectionMatrix).invert(),Vt.viewport.set(ie.x,ie.y,ie.width,ie.height),It===0&&(V.matrix.copy(Vt.matrix),V.matrix.decompose(V.position,V.quaternion,V.scale)),Rt===!0&&V.cameras.push(Vt)}let vt=s.enabledFeatures;if(vt&&vt.includes("depth-sensing")&&s.depthUsage=="gpu-optimized"&&x){d=n.getBinding();let It=d.getDepthInformation(bt[0]);It&&It.isValid&&It.texture&&p.init(It,s.renderState)}if(vt&&vt.includes("camera-access")&&x){t.state.unbindTexture(),d=n.getBinding();for(let It=0;It<bt.length;It++){let te=bt[It].camera;if(te){let ie=m[te];ie||(ie=new Ar,m[te]=ie);let Vt=d.getCameraImage(te);ie.sourceTexture=Vt}}}}for(let bt=0;bt<T.length;bt++){let Rt=E[bt],vt=T[bt];Rt!==null&&vt!==void 0&&vt.update(Rt,gt,c||o)}et&&et(Z,gt),gt.detectedPlanes&&n.dispatchEvent({type:"planesdetected",data:gt}),g=null}let Dt=new Rp;Dt.setAnimationLoop(yt),this.setAnimationLoop=function(Z){et=Z},this.dispose=function(){}}},ES=new jt,kp=new Nt;kp.set(-1,0,0,0,1,0,0,0,1);function AS(i,t){function e(p,m){p.matrixAutoUpdate===!0&&p.updateMatrix(),m.value.copy(p.matrix)}function n(p,m){m.color.getRGB(p.fogColor.value,nu(i)),m.isFog?(p.fogNear.value=m.near,p.fogFar.value=m.far):m.isFogExp2&&(p.fogDensity.value=m.density)}function s(p,m,_,M,y){m.isNodeMaterial?m.uniformsNeedUpdate=!1:m.isMeshBasicMaterial?r(p,m):m.isMeshLambertMaterial?(r(p,m),m.envMap&&(p.envMapIntensity.value=m.envMapIntensity)):m.isMeshToonMaterial?(r(p,m),d(p,m)):m.isMeshPhongMaterial?(r(p,m),h(p,m),m.envMap&&(p.envMapIntensity.value=m.envMapIntensity)):m.isMeshStandardMaterial?(r(p,m),u(p,m),m.isMeshPhysicalMaterial&&f(p,m,y)):m.isMeshMatcapMaterial?(r(p,m),g(p,m)):m.isMeshDepthMaterial?r(p,m):m.isMeshDistanceMaterial?(r(p,m),x(p,m)):m.isMeshNormalMaterial?r(p,m):m.isLineBasicMaterial?(o(p,m),m.isLineDashedMaterial&&a(p,m)):m.isPointsMaterial?l(p,m,_,M):m.isSpriteMaterial?c(p,m):m.isShadowMaterial?(p.color.value.copy(m.color),p.opacity.value=m.opacity):m.isShaderMaterial&&(m.uniformsNeedUpdate=!1)}function r(p,m){p.opacity.value=m.opacity,m.color&&p.diffuse.value.copy(m.color),m.emissive&&p.emissive.value.copy(m.emissive).multiplyScalar(m.emissiveIntensity),m.map&&(p.map.value=m.map,e(m.map,p.mapTransform)),m.alphaMap&&(p.alphaMap.value=m.alphaMap,e(m.alphaMap,p.alphaMapTransform)),m.bumpMap&&(p.bumpMap.value=m.bumpMap,e(m.bumpMap,p.bumpMapTransform),p.bumpScale.value=m.bumpScale,m.side===Ae&&(p.bumpScale.value*=-1)),m.normalMap&&(p.normalMap.value=m.normalMap,e(m.normalMap,p.normalMapTransform),p.normalScale.value.copy(m.normalScale),m.side===Ae&&p.normalScale.value.negate()),m.displacementMap&&(p.displacementMap.value=m.displacementMap,e(m.displacementMap,p.displacementMapTransform),p.displacementScale.value=m.displacementScale,p.displacementBias.value=m.displacementBias),m.emissiveMap&&(p.emissiveMap.value=m.emissiveMap,e(m.emissiveMap,p.emissiveMapTransform)),m.specularMap&&(p.specularMap.value=m.specularMap,e(m.specularMap,p.specularMapTransform)),m.alphaTest>0&&(p.alphaTest.value=m.alphaTest);let _=t.get(m),M=_.envMap,y=_.envMapRotation;M&&(p.envMap.value=M,p.envMapRotation.value.setFromMatrix4(ES.makeRotationFromEuler(y)).transpose(),M.isCubeTexture&&M.isRenderTargetTexture===!1&&p.envMapRotation.value.premultiply(kp),p.reflectivity.value=m.reflectivity,p.ior.value=m.ior,p.refractionRatio.value=m.refractionRatio),m.lightMap&&(p.lightMap.value=m.lightMap,p.lightMapIntensity.value=m.lightMapIntensity,e(m.lightMap,p.lightMapTransform)),m.aoMap&&(p.aoMap.value=m.aoMap,p.aoMapIntensity.value=m.aoMapIntensity,e(m.aoMap,p.aoMapTransform))}function o(p,m){p.diffuse.value.copy(m.color),p.opacity.value=m.opacity,m.map&&(p.map.value=m.map,e(m.map,p.mapTransform))}function a(p,m){p.dashSize.value=m.dashSize,p.totalSize.value=m.dashSize+m.gapSize,p.scale.value=m.scale}function l(p,m,_,M){p.diffuse.value.copy(m.color),p.opacity.value=m.opacity,p.size.value=m.size*_,p.scale.value=M*.5,m.map&&(p.map.value=m.map,e(m.map,p.uvTransform)),m.alphaMap&&(p.alphaMap.value=m.alphaMap,e(m.alphaMap,p.alphaMapTransform)),m.alphaTest>0&&(p.alphaTest.value=m.alphaTest)}function c(p,m){p.diffuse.value.copy(m.color),p.opacity.value=m.opacity,p.rotation.value=m.rotation,m.map&&(p.map.value=m.map,e(m.map,p.mapTransform)),m.alphaMap&&(p.alphaMap.value=m.alphaMap,e(m.alphaMap,p.alphaMapTransform)),m.alphaTest>0&&(p.alphaTest.value=m.alphaTest)}function h(p,m){p.specular.value.copy(m.specular),p.shininess.value=Math.max(m.shininess,1e-4)}function d(p,m){m.gradientMap&&(p.gradientMap.value=m.gradientMap)}function u(p,m){p.metalness.value=m.metalness,m.metalnessMap&&(p.metalnessMap.value=m.metalnessMap,e(m.metalnessMap,p.metalnessMapTransform)),p.roughness.value=m.roughness,m.roughnessMap&&(p.roughnessMap.value=m.roughnessMap,e(m.roughnessMap,p.roughnessMapTransform)),m.envMap&&(p.envMapIntensity.value=m.envMapIntensity)}function f(p,m,_){p.ior.value=m.ior,m.diffuseRoughness>0&&(p.diffuseRoughness.value=m.diffuseRoughness,m.diffuseRoughnessMap&&(p.diffuseRoughnessMap.value=m.diffuseRoughnessMap,e(m.diffuseRoughnessMap,p.diffuseRoughnessMapTransform))),m.sheen>0&&(p.sheenColor.value.copy(m.sheenColor).multiplyScalar(m.sheen),p.sheenRoughness.value=m.sheenRoughness,m.sheenColorMap&&(p.sheenColorMap.value=m.sheenColorMap,e(m.sheenColorMap,p.sheenColorMapTransform)),m.sheenRoughnessMap&&(p.sheenRoughnessMap.value=m.sheenRoughnessMap,e(m.sheenRoughnessMap,p.sheenRoughnessMapTransform))),m.clearcoat>0&&(p.clearcoat.value=m.clearcoat,p.clearcoatRoughness.value=m.clearcoatRoughness,m.clearcoatMap&&(p.clearcoatMap.value=m.clearcoatMap,e(m.clearcoatMap,p.clearcoatMapTransform)),m.clearcoatRoughnessMap&&(p.clearcoatRoughnessMap.value=m.clearcoatRoughnessMap,e(m.clearcoatRoughnessMap,p.clearcoatRoughnessMapTransform)),m.clearcoatNormalMap&&(p.clearcoatNormalMap.value=m.clearcoatNormalMap,e(m.clearcoatNormalMap,p.clearcoatNormalMapTransform),p.clearcoatNormalScale.value.copy(m.clearcoatNormalScale),m.side===Ae&&p.clearcoatNormalScale.value.negate())),m.dispersion>0&&(p.dispersion.value=m.dispersion),m.retroreflectivity>0&&(p.retroreflectivity.value=m.retroreflectivity),m.iridescence>0&&(p.iridescence.value=m.iridescence,p.iridescenceIOR.value=m.iridescenceIOR,p.iridescenceThicknessMinimum.value=m.iridescenceThicknessMinimum,p.iridescenceThicknessMaximum.value=m.iridescenceThicknessMaximum,m.iridescenceMap&&(p.iridescenceMap.value=m.iridescenceMap,e(m.iridescenceMap,p.iridescenceMapTransform)),m.iridescenceThicknessMap&&(p.iridescenceThicknessMap.value=m.iridescenceThicknessMap,e(m.iridescenceThicknessMap,p.iridescenceThicknessMapTransform))),m.transmission>0&&(p.transmission.value=m.transmission,p.transmissionSamplerMap.value=_.texture,p.transmissionSamplerSize.value.set(_.width,_.height),m.transmissionMap&&(p.transmissionMap.value=m.transmissionMap,e(m.transmissionMap,p.transmissionMapTransform)),p.thickness.value=m.thickness,m.thicknessMap&&(p.thicknessMap.value=m.thicknessMap,e(m.thicknessMap,p.thicknessMapTransform)),p.attenuationDistance.value=m.attenuationDistance,p.attenuationColor.value.copy(m.attenuationColor)),m.anisotropy>0&&(p.anisotropyVector.value.set(m.anisotropy*Math.cos(m.anisotropyRotation),m.anisotropy*Math.sin(m.anisotropyRotation)),m.anisotropyMap&&(p.anisotropyMap.value=m.anisotropyMap,e(m.anisotropyMap,p.anisotropyMapTransform))),p.specularIntensity.value=m.specularIntensity,p.specularColor.value.copy(m.specularColor),m.specularColorMap&&(p.specularColorMap.value=m.specularColorMap,e(m.specularColorMap,p.specularColorMapTransform)),m.specularIntensityMap&&(p.specularIntensityMap.value=m.specularIntensityMap,e(m.specularIntensityMap,p.specularIntensityMapTransform))}function g(p,m){m.matcap&&(p.matcap.value=m.matcap)}function x(p,m){let _=t.get(m).light;p.referencePosition.value.setFromMatrixPosition(_.matrixWorld),p.nearDistance.value=_.shadow.camera.near,p.farDistance.value=_.shadow.camera.far}return{refreshFogUniforms:n,refreshMaterialUniforms:s}}function TS(i,t,e,n){let s={},r={};function o(_,M){let y=M.program;n.uniformBlockBinding(_,y,s[_.id])}function a(_,M){let y=s[_.id];y===void 0&&(g(_),y=l(_),s[_.id]=y,_.addEventListener("dispose",p));let T=M.program;n.updateUBOMapping(_,T);let E=t.render.frame;r[_.id]!==E&&(c(_),r[_.id]=E)}function l(_){let M=i.createBuffer(),y=_.__size,T=_.usage;return i.bindBuffer(i.UNIFORM_BUFFER,M),i.bufferData(i.UNIFORM_BUFFER,y,T),i.bindBuffer(i.UNIFORM_BUFFER,null),M}function c(_){let M=s[_.id],y=_.uniforms,T=_.__cache;i.bindBuffer(i.UNIFORM_BUFFER,M);for(let E=0,v=y.length;E<v;E++){let w=y[E];if(Array.isArray(w))for(let F=0,D=w.length;F<D;F++)h(w[F],E,F,T);else h(w,E,0,T)}i.bindBuffer(i.UNIFORM_BUFFER,null)}function h(_,M,y,T){if(u(_,M,y,T)===!0){let E=_.__offset,v=_.value;if(Array.isArray(v)){let w=0;for(let F=0;F<v.length;F++){let D=v[F],N=x(D,!0);d(D,_.__data,w),w+=N.storage/Float32Array.BYTES_PER_ELEMENT}}else d(v,_.__data,0);i.bufferSubData(i.UNIFORM_BUFFER,E,_.__data)}}function d(_,M,y){typeof _=="number"||typeof _=="boolean"?M[y]=_:_.isMatrix3?(M[y]=_.elements[0],M[y+1]=_.elements[1],M[y+2]=_.elements[2],M[y+3]=0,M[y+4]=_.elements[3],M[y+5]=_.elements[4],M[y+6]=_.elements[5],M[y+7]=0,M[y+8]=_.elements[6],M[y+9]=_.elements[7],M[y+10]=_.elements[8],M[y+11]=0):ArrayBuffer.isView(_)?M.set(_.subarray(0,M.length-y),y):_.toArray(M,y)}function u(_,M,y,T){let E=_.value,v=M+"_"+y;if(Array.isArray(E)){T[v]===void 0&&(T[v]=[]);let w=T[v],F=!1;for(let D=0;D<E.length;D++)f(E[D],w,D)===!0&&(F=!0);return F}return f(E,T,v)}function f(_,M,y){if(M[y]===void 0)return typeof _=="number"||typeof _=="boolean"?M[y]=_:ArrayBuffer.isView(_)?M[y]=_.slice():M[y]=_.clone(),!0;{let T=M[y];if(typeof _=="number"||typeof _=="boolean"){if(T!==_)return M[y]=_,!0}else{if(ArrayBuffer.isView(_))return!0;if(T.equals(_)===!1)return T.copy(_),!0}}return!1}function g(_){let M=_.uniforms,y=0,T=16;for(let v=0,w=M.length;v<w;v++){let F=Array.isArray(M[v])?M[v]:[M[v]];for(let D=0,N=F.length;D<N;D++){let O=F[D],V=Array.isArray(O.value)?O.value:[O.value],C=Array.isArray(M[v])||Array.isArray(O.value),H=y;for(let G=0,nt=V.length;G<nt;G++){let $=V[G],Q=x($,C),et=y%T,yt=et%Q.boundary,Dt=et+yt;y+=yt,Dt!==0&&T-Dt<Q.storage&&(y+=T-Dt),G===0&&(H=y),y+=Q.storage}let X=O.type==="int"?Int32Array:O.type==="uint"?Uint32Array:Float32Array;O.__data=new X((y-H)/Float32Array.BYTES_PER_ELEMENT),O.__offset=H}}let E=y%T;return E>0&&(y+=T-E),_.__size=y,_.__cache={},this}function x(_,M){let y={boundary:0,storage:0};return typeof _=="number"||typeof _=="boolean"?(y.boundary=4,y.storage=4):_.isVector2?(y.boundary=8,y.storage=8):_.isVector3||_.isColor?(y.boundary=16,y.storage=12):_.isVector4?(y.boundary=16,y.storage=16):_.isMatrix3?(y.boundary=16,y.storage=48):_.isMatrix4?(y.boundary=16,y.storage=64):_.isTexture?Tt("WebGLRenderer: Texture samplers can not be part of an uniforms group."):ArrayBuffer.isView(_)?(y.boundary=16,y.storage=_.byteLength):Tt("WebGLRenderer: Unsupported uniform value type.",_),M===!0&&(y.boundary=16,y.storage=Math.ceil(y.storage/16)*16),y}function p(_){let M=_.target;M.removeEventListener("dispose",p),i.deleteBuffer(s[M.id]),delete s[M.id],delete r[M.id]}function m(){for(let _ in s)i.deleteBuffer(s[_]);s={},r={}}return{bind:o,update:a,dispose:m}}var CS=new Uint16Array([12469,15057,12620,14925,13266,14620,13807,14376,14323,13990,14545,13625,14713,13328,14840,12882,14931,12528,14996,12233,15039,11829,15066,11525,15080,11295,15085,10976,15082,10705,15073,10495,13880,14564,13898,14542,13977,14430,14158,14124,14393,13732,14556,13410,14702,12996,14814,12596,14891,12291,14937,11834,14957,11489,14958,11194,14943,10803,14921,10506,14893,10278,14858,9960,14484,14039,14487,14025,14499,13941,14524,13740,14574,13468,14654,13106,14743,12678,14818,12344,14867,11893,14889,11509,14893,11180,14881,10751,14852,10428,14812,10128,14765,9754,14712,9466,14764,13480,14764,13475,14766,13440,14766,13347,14769,13070,14786,12713,14816,12387,14844,11957,14860,11549,14868,11215,14855,10751,14825,10403,14782,10044,14729,9651,14666,9352,14599,9029,14967,12835,14966,12831,14963,12804,14954,12723,14936,12564,14917,12347,14900,11958,14886,11569,14878,11247,14859,10765,14828,10401,14784,10011,14727,9600,14660,9289,14586,8893,14508,8533,15111,12234,15110,12234,15104,12216,15092,12156,15067,12010,15028,11776,14981,11500,14942,11205,14902,10752,14861,10393,14812,9991,14752,9570,14682,9252,14603,8808,14519,8445,14431,8145,15209,11449,15208,11451,15202,11451,15190,11438,15163,11384,15117,11274,15055,10979,14994,10648,14932,10343,14871,9936,14803,9532,14729,9218,14645,8742,14556,8381,14461,8020,14365,7603,15273,10603,15272,10607,15267,10619,15256,10631,15231,10614,15182,10535,15118,10389,15042,10167,14963,9787,14883,9447,14800,9115,14710,8665,14615,8318,14514,7911,14411,7507,14279,7198,15314,9675,15313,9683,15309,9712,15298,9759,15277,9797,15229,9773,15166,9668,15084,9487,14995,9274,14898,8910,14800,8539,14697,8234,14590,7790,14479,7409,14367,7067,14178,6621,15337,8619,15337,8631,15333,8677,15325,8769,15305,8871,15264,8940,15202,8909,15119,8775,15022,8565,14916,8328,14804,8009,14688,7614,14569,7287,14448,6888,14321,6483,14088,6171,15350,7402,15350,7419,15347,7480,15340,7613,15322,7804,15287,7973,15229,8057,15148,8012,15046,7846,14933,7611,14810,7357,14682,7069,14552,6656,14421,6316,14251,5948,14007,5528,15356,5942,15356,5977,15353,6119,15348,6294,15332,6551,15302,6824,15249,7044,15171,7122,15070,7050,14949,6861,14818,6611,14679,6349,14538,6067,14398,5651,14189,5311,13935,4958,15359,4123,15359,4153,15356,4296,15353,4646,15338,5160,15311,5508,15263,5829,15188,6042,15088,6094,14966,6001,14826,5796,14678,5543,14527,5287,14377,4985,14133,4586,13869,4257,15360,1563,15360,1642,15358,2076,15354,2636,15341,3350,15317,4019,15273,4429,15203,4732,15105,4911,14981,4932,14836,4818,14679,4621,14517,4386,14359,4156,14083,3795,13808,3437,15360,122,15360,137,15358,285,15355,636,15344,1274,15322,2177,15281,2765,15215,3223,15120,3451,14995,3569,14846,3567,14681,3466,14511,3305,14344,3121,14037,2800,13753,2467,15360,0,15360,1,15359,21,15355,89,15346,253,15325,479,15287,796,15225,1148,15133,1492,15008,1749,14856,1882,14685,1886,14506,1783,14324,1608,13996,1398,13702,1183]),Kn=null;function RS(){return Kn===null&&(Kn=new Us(CS,16,16,zi,xn),Kn.name="DFG_LUT",Kn.minFilter=Be,Kn.magFilter=Be,Kn.wrapS=jn,Kn.wrapT=jn,Kn.generateMipmaps=!1,Kn.needsUpdate=!0),Kn}var Sl=class{constructor(t={}){let{canvas:e=Kf(),context:n=null,depth:s=!0,stencil:r=!1,alpha:o=!1,antialias:a=!1,premultipliedAlpha:l=!0,preserveDrawingBuffer:c=!1,powerPreference:h="default",failIfMajorPerformanceCaveat:d=!1,reversedDepthBuffer:u=!1,outputBufferType:f=vn}=t;this.isWebGLRenderer=!0;let g;if(n!==null){if(typeof WebGLRenderingContext<"u"&&n instanceof WebGLRenderingContext)throw new Error("THREE.WebGLRenderer: WebGL 1 is not supported since r163.");g=n.getContextAttributes().alpha}else g=o;let x=f,p=new Set([za,ka,Ba]),m=new Set([vn,Hn,Vs,os,Fa,Oa]),_=new Uint32Array(4),M=new Int32Array(4),y={textures:[],min:[],max:[],resolution:[]},T=null,E=null,v=[],w=[],F=null;this.domElement=e,this.debug={checkShaderErrors:!0,diagnostics:{keywords:!1},onShaderError:null},this.autoClear=!0,this.autoClearColor=!0,this.autoClearDepth=!0,this.autoClearStencil=!0,this.sortObjects=!0,this.clippingPlanes=[],this.localClippingEnabled=!1,this.toneMapping=Zn,this.toneMappingExposure=1,this.transmissionResolutionScale=1;let D=this,N=!1,O=null,V=null,C=null,H=null;this._outputColorSpace=dn;let X=0,G=0,nt=null,$=-1,Q=null,et=new ne,yt=new ne,Dt=null,Z=new Gt(0),gt=0,bt=e.width,Rt=e.height,vt=1,Bt=null,xe=null,It=new ne(0,0,bt,Rt),te=new ne(0,0,bt,Rt),ie=!1,Vt=new es,Fe=new pa,Me=!1,rn=!1,de=new jt,qn=new P,Pe=new ne,Sn={background:null,fog:null,environment:null,overrideMaterial:null,isScene:!0},Mn=!1;function wn(){return nt===null?vt:1}let U=n;function En(S,I){return e.getContext(S,I)}let le,ce,pt,we,Pt,Ut,A,b,k,it,J,ot,ut,Y,j,lt,R,K,q,ct,rt,at,Et;try{let S={alpha:!0,depth:s,stencil:r,antialias:a,premultipliedAlpha:l,preserveDrawingBuffer:c,powerPreference:h,failIfMajorPerformanceCaveat:d};if("setAttribute"in e&&e.setAttribute("data-engine",`three.js r${"187"}`),e.addEventListener("webglcontextlost",At,!1),e.addEventListener("webglcontextrestored",kt,!1),e.addEventListener("webglcontextcreationerror",mt,!1),U===null){let I="webgl2";if(U=En(I,S),U===null)throw En(I)?new Error("THREE.WebGLRenderer: Error creating WebGL context with your selected attributes."):new Error("THREE.WebGLRenderer: Error creating WebGL context.")}zt()}catch(S){throw e.removeEventListener("webglcontextlost",At,!1),e.removeEventListener("webglcontextrestored",kt,!1),e.removeEventListener("webglcontextcreationerror",mt,!1),Lt("WebGLRenderer: "+S.message),S}function zt(){le=new zy(U),le.init(),rt=new SS(U,le),ce=new Ry(U,le,t,rt),pt=new yS(U,le),ce.reversedDepthBuffer&&u&&pt.buffers.depth.setReversed(!0),V=U.createFramebuffer(),C=U.createFramebuffer(),H=U.createFramebuffer(),we=new Vy(U),Pt=new oS,Ut=new bS(U,le,pt,Pt,ce,rt,we),A=new ky(D),b=new $v(U),at=new Ty(U,b),k=new Hy(U,b,we,at),it=new $y(U,k,b,at,we),K=new Wy(U,ce,Ut),j=new Py(Pt),J=new rS(D,A,le,ce,at,j),ot=new AS(D,Pt),ut=new lS,Y=new pS(le),R=new Ay(D,A,pt,it,g,l),lt=new _S(D,it,ce),Et=new TS(U,we,ce,pt),q=new Cy(U,le,we),ct=new Gy(U,le,we),we.programs=J.programs,D.capabilities=ce,D.extensions=le,D.properties=Pt,D.renderLists=ut,D.shadowMap=lt,D.state=pt,D.info=we}x!==vn&&(F=new qy(x,e.width,e.height,a,s,r));let st=new mu(D,U);this.xr=st,this.getContext=function(){return U},this.getContextAttributes=function(){return U.getContextAttributes()},this.forceContextLoss=function(){let S=le.get("WEBGL_lose_context");S&&S.loseContext()},this.forceContextRestore=function(){let S=le.get("WEBGL_lose_context");S&&S.restoreContext()},this.getPixelRatio=function(){return vt},this.setPixelRatio=function(S){S!==void 0&&(vt=S,this.setSize(bt,Rt,!1))},this.getSize=function(S){return S.set(bt,Rt)},this.setSize=function(S,I,W=!0){if(st.isPresenting){Tt("WebGLRenderer: Can't change size while VR device is presenting.");return}bt=S,Rt=I,e.width=Math.floor(S*vt),e.height=Math.floor(I*vt),W===!0&&(e.style.width=S+"px",e.style.height=I+"px"),F!==null&&F.setSize(e.width,e.height),this.setViewport(0,0,S,I)},this.getDrawingBufferSize=function(S){return S.set(bt*vt,Rt*vt).floor()},this.setDrawingBufferSize=function(S,I,W){bt=S,Rt=I,vt=W,e.width=Math.floor(S*W),e.height=Math.floor(I*W),this.setViewport(0,0,S,I)},this.setEffects=function(S){if(x===vn){Lt("WebGLRenderer: setEffects() requires outputBufferType set to HalfFloatType or FloatType.");return}if(S){for(let I=0;I<S.length;I++)if(S[I].isOutputPass===!0){Tt("WebGLRenderer: OutputPass is not needed in setEffects(). Tone mapping and color space conversion are applied automatically.");break}}F.setEffects(S||[])},this.getCurrentViewport=function(S){return S.copy(et)},this.getViewport=function(S){return S.copy(It)},this.setViewport=function(S,I,W,B){S.isVector4?It.set(S.x,S.y,S.z,S.w):It.set(S,I,W,B),pt.viewport(et.copy(It).multiplyScalar(wn()).round())},this.getScissor=function(S){return S.copy(te)},this.setScissor=function(S,I,W,B){S.isVector4?te.set(S.x,S.y,S.z,S.w):te.set(S,I,W,B),pt.scissor(yt.copy(te).multiplyScalar(wn()).round())},this.getScissorTest=function(){return ie},this.setScissorTest=function(S){pt.setScissorTest(ie=S)},this.setOpaqueSort=function(S){Bt=S},this.setTransparentSort=function(S){xe=S},this.getClearColor=function(S){return S.copy(R.getClearColor())},this.setClearColor=function(){R.setClearColor(...arguments)},this.getClearAlpha=function(){return R.getClearAlpha()},this.setClearAlpha=function(){R.setClearAlpha(...arguments)},this.clear=function(S=!0,I=!0,W=!0){let B=0;if(S){let z=!1;if(nt!==null){let dt=nt.texture.format;z=p.has(dt)}if(z){let dt=nt.texture.type,_t=m.has(dt),ht=R.getClearColor(),xt=R.getClearAlpha(),wt=ht.r,Ot=ht.g,Wt=ht.b;_t?(_[0]=wt,_[1]=Ot,_[2]=Wt,_[3]=xt,U.clearBufferuiv(U.COLOR,0,_)):(M[0]=wt,M[1]=Ot,M[2]=Wt,M[3]=xt,U.clearBufferiv(U.COLOR,0,M))}else B|=U.COLOR_BUFFER_BIT}I&&(B|=U.DEPTH_BUFFER_BIT,this.state.buffers.depth.setMask(!0)),W&&(B|=U.STENCIL_BUFFER_BIT,this.state.buffers.stencil.setMask(4294967295)),B!==0&&U.clear(B)},this.clearColor=function(){this.clear(!0,!1,!1)},this.clearDepth=function(){this.clear(!1,!0,!1)},this.clearStencil=function(){this.clear(!1,!1,!0)},this.setNodesHandler=function(S){S.setRenderer(this),O=S},this.dispose=function(){e.removeEventListener("webglcontextlost",At,!1),e.removeEventListener("webglcontextrestored",kt,!1),e.removeEventListener("webglcontextcreationerror",mt,!1),R.dispose(),ut.dispose(),Y.dispose(),Ut.dispose(),Pt.dispose(),A.dispose(),it.dispose(),k.dispose(),at.dispose(),Et.dispose(),J.dispose(),st.dispose(),st.removeEventListener("sessionstart",ud),st.removeEventListener("sessionend",dd),Xi.stop()};function At(S){S.preventDefault(),_r("WebGLRenderer: Context Lost."),N=!0}function kt(){_r("WebGLRenderer: Context Restored."),N=!1;let S=we.autoReset,I=lt.enabled,W=lt.autoUpdate,B=lt.needsUpdate,z=lt.type;zt(),we.autoReset=S,lt.enabled=I,lt.autoUpdate=W,lt.needsUpdate=B,lt.type=z}function mt(S){Lt("WebGLRenderer: A WebGL context could not be created. Reason: ",S.statusMessage)}function ee(S){let I=S.target;I.removeEventListener("dispose",ee),Ie(I)}function Ie(S){Ei(S),Pt.remove(S)}function Ei(S){let I=Pt.get(S).programs;I!==void 0&&(I.forEach(function(W){J.releaseProgram(W)}),S.isShaderMaterial&&J.releaseShaderCache(S))}this.renderBufferDirect=function(S,I,W,B,z,dt){I===null&&(I=Sn);let _t=z.isMesh&&z.matrixWorld.determinantAffine()<0,ht=m0(S,I,W,B,z);pt.setMaterial(B,_t);let xt=W.index,wt=1;if(B.wireframe===!0){if(xt=k.getWireframeAttribute(W),xt===void 0)return;wt=2}let Ot=W.drawRange,Wt=W.attributes.position,St=Ot.start*wt,$t=(Ot.start+Ot.count)*wt;dt!==null&&(St=Math.max(St,dt.start*wt),$t=Math.min($t,(dt.start+dt.count)*wt)),xt!==null?(St=Math.max(St,0),$t=Math.min($t,xt.count)):Wt!=null&&(St=Math.max(St,0),$t=Math.min($t,Wt.count));let _e=$t-St;if(_e<0||_e===1/0)return;at.setup(z,B,ht,W,xt);let re,se=q;if(xt!==null&&(re=b.get(xt),se=ct,se.setIndex(re)),z.isMesh)B.wireframe===!0?(pt.setLineWidth(B.wireframeLinewidth*wn()),se.setMode(U.LINES)):se.setMode(U.TRIANGLES);else if(z.isLine){let Ge=B.linewidth;Ge===void 0&&(Ge=1),pt.setLineWidth(Ge*wn()),z.isLineSegments?se.setMode(U.LINES):z.isLineLoop?se.setMode(U.LINE_LOOP):se.setMode(U.LINE_STRIP)}else z.isPoints?se.setMode(U.POINTS):z.isSprite&&se.setMode(U.TRIANGLES);if(z.isBatchedMesh)if(le.get("WEBGL_multi_draw"))se.renderMultiDraw(z._multiDrawStarts,z._multiDrawCounts,z._multiDrawCount);else{let Ge=z._multiDrawStarts,Mt=z._multiDrawCounts,Je=z._multiDrawCount,Zt=xt?b.get(xt).bytesPerElement:1,qi=Pt.get(B).currentProgram.getUniforms();for(let Ve=0;Ve<Je;Ve++)qi.setValue(U,"_gl_DrawID",Ve),se.render(Ge[Ve]/Zt,Mt[Ve])}else if(z.isInstancedMesh)se.renderInstances(St,_e,z.count);else if(W.isInstancedBufferGeometry){let Ge=W._maxInstanceCount!==void 0?W._maxInstanceCount:1/0,Mt=Math.min(W.instanceCount,Ge);se.renderInstances(St,_e,Mt)}else se.render(St,_e)};function hd(S,I,W,B){O!==null&&S.isNodeMaterial&&O.setObject(B,S),Me===!0&&j.setState(S,W,!1),S.transparent===!0&&S.side===en&&S.forceSinglePass===!1?(S.side=Ae,S.needsUpdate=!0,nr(S,I,B),S.side=zn,S.needsUpdate=!0,nr(S,I,B),S.side=en):nr(S,I,B)}this.compile=function(S,I,W=null){W===null&&(W=S),O!==null&&O.renderStart(S,I,W),E=Y.get(W),E.init(I),w.push(E),W.traverseVisible(function(z){z.isLight&&z.layers.test(I.layers)&&(E.pushLight(z),z.castShadow&&E.pushShadow(z))}),S!==W&&S.traverseVisible(function(z){z.isLight&&z.layers.test(I.layers)&&(E.pushLight(z),z.castShadow&&E.pushShadow(z))}),E.setupLights(),O!==null&&O.updateLights(E.state.lightsArray),rn=this.localClippingEnabled,Me=j.init(this.clippingPlanes,rn),Me===!0&&j.setGlobalState(this.clippingPlanes,I),O!==null&&lt.render(E.state.shadowsArray,W,I);let B=new Set;return S.traverse(function(z){if(!(z.isMesh||z.isPoints||z.isLine||z.isSprite))return;let dt=z.material;if(dt)if(Array.isArray(dt))for(let _t=0;_t<dt.length;_t++){let ht=dt[_t];hd(ht,W,I,z),B.add(ht)}else hd(dt,W,I,z),B.add(dt)}),E=w.pop(),O!==null&&O.renderEnd(),B},this.compileAsync=function(S,I,W=null){let B=this.compile(S,I,W);return new Promise(z=>{function dt(){if(B.forEach(function(_t){let xt=Pt.get(_t).currentProgram;(xt===void 0||xt.isReady())&&B.delete(_t)}),B.size===0){z(S);return}setTimeout(dt,10)}le.get("KHR_parallel_shader_compile")!==null?dt():setTimeout(dt,10)})};let Uc=null;function f0(S){Uc&&Uc(S)}function ud(){Xi.stop()}function dd(){Xi.start()}let Xi=new Rp;Xi.setAnimationLoop(f0),typeof self<"u"&&Xi.setContext(self),this.setAnimationLoop=function(S){Uc=S,st.setAnimationLoop(S),S===null?Xi.stop():Xi.start()},st.addEventListener("sessionstart",ud),st.addEventListener("sessionend",dd),this.render=function(S,I){if(I!==void 0&&I.isCamera!==!0){Lt("WebGLRenderer.render: camera is not an instance of THREE.Camera.");return}if(N===!0)return;O!==null&&O.renderStart(S,I);let W=st.enabled===!0&&st.isPresenting===!0,B=F!==null&&(nt===null||W)&&F.begin(D,nt);if(S.matrixWorldAutoUpdate===!0&&S.updateMatrixWorld(),I.parent===null&&I.matrixWorldAutoUpdate===!0&&I.updateMatrixWorld(),st.enabled===!0&&st.isPresenting===!0&&(F===null||F.isCompositing()===!1)&&(st.cameraAutoUpdate===!0&&st.updateCamera(I),I=st.getCamera()),S.isScene===!0&&S.onBeforeRender(D,S,I,nt),E=Y.get(S,w.length),E.init(I),E.state.textureUnits=Ut.getTextureUnits(),w.push(E),de.multiplyMatrices(I.projectionMatrix,I.matrixWorldInverse),I.isArrayCamera?Fe.setFromArrayCamera(I):Vt.setFromProjectionMatrix(de,Tn,I.reversedDepth),rn=this.localClippingEnabled,Me=j.init(this.clippingPlanes,rn),T=ut.get(S,v.length),T.init(),v.push(T),this.info.render.frame++,st.enabled===!0&&st.isPresenting===!0){let _t=D.xr.getDepthSensingMesh();_t!==null&&Fc(_t,I,-1/0,D.sortObjects)}Fc(S,I,0,D.sortObjects),T.finish(),O!==null&&O.updateLights(E.state.lightsArray),D.sortObjects===!0&&T.sort(Bt,xe),Mn=st.enabled===!1||st.isPresenting===!1||st.hasDepthSensing()===!1,Mn&&R.addToRenderList(T,S),this.info.autoReset===!0&&this.info.reset(),Me===!0&&j.beginShadows();let z=E.state.shadowsArray;if(lt.render(z,S,I),Me===!0&&j.endShadows(),(B&&F.hasRenderPass())===!1){let _t=T.opaque,ht=T.transmissive;if(E.setupLights(),I.isArrayCamera){let xt=I.cameras;if(ht.length>0)for(let wt=0,Ot=xt.length;wt<Ot;wt++){let Wt=xt[wt];pd(_t,ht,S,Wt)}Mn&&R.render(S);for(let wt=0,Ot=xt.length;wt<Ot;wt++){let Wt=xt[wt];fd(T,S,Wt,Wt.viewport)}}else ht.length>0&&pd(_t,ht,S,I),Mn&&R.render(S),fd(T,S,I)}nt!==null&&G===0&&(Ut.updateMultisampleRenderTarget(nt),Ut.updateRenderTargetMipmap(nt)),B&&F.end(D),S.isScene===!0&&S.onAfterRender(D,S,I),at.resetDefaultState(),$=-1,Q=null,w.pop(),w.length>0?(E=w[w.length-1],Ut.setTextureUnits(E.state.textureUnits),Me===!0&&j.setGlobalState(D.clippingPlanes,E.state.camera)):E=null,v.pop(),v.length>0?T=v[v.length-1]:T=null,O!==null&&O.renderEnd()};function Fc(S,I,W,B){if(S.visible===!1)return;if(S.layers.test(I.layers)){if(S.isGroup)W=S.renderOrder;else if(S.isLOD)S.autoUpdate===!0&&S.update(I);else if(S.isLight)E.pushLight(S),S.castShadow&&E.pushShadow(S);else if(S.isSprite){let _t=I.isArrayCamera?Fe:Vt;if(!S.frustumCulled||S.intersectsFrustum(_t)){B&&Pe.setFromMatrixPosition(S.matrixWorld).applyMatrix4(de);let ht=it.update(S),xt=S.material;xt.visible&&T.push(S,ht,xt,W,Pe.z,null,I)}}else if(S.isMesh||S.isLine||S.isPoints){let _t=I.isArrayCamera?Fe:Vt;if(!S.frustumCulled||S.intersectsFrustum(_t)){let ht=it.update(S),xt=S.material;if(B&&(S.boundingSphere!==void 0?(S.boundingSphere===null&&S.computeBoundingSphere(),Pe.copy(S.boundingSphere.center)):(ht.boundingSphere===null&&ht.computeBoundingSphere(),Pe.copy(ht.boundingSphere.center)),Pe.applyMatrix4(S.matrixWorld).applyMatrix4(de)),Array.isArray(xt)){let wt=ht.groups;for(let Ot=0,Wt=wt.length;Ot<Wt;Ot++){let St=wt[Ot],$t=xt[St.materialIndex];$t&&$t.visible&&T.push(S,ht,$t,W,Pe.z,St,I)}}else xt.visible&&T.push(S,ht,xt,W,Pe.z,null,I)}}}let dt=S.children;for(let _t=0,ht=dt.length;_t<ht;_t++)Fc(dt[_t],I,W,B)}function fd(S,I,W,B){let{opaque:z,transmissive:dt,transparent:_t}=S;E.setupLightsView(W),Me===!0&&j.setGlobalState(D.clippingPlanes,W),B&&pt.viewport(et.copy(B)),z.length>0&&xo(z,I,W),dt.length>0&&xo(dt,I,W),_t.length>0&&xo(_t,I,W),pt.buffers.depth.setTest(!0),pt.buffers.depth.setMask(!0),pt.buffers.color.setMask(!0),pt.setPolygonOffset(!1)}function pd(S,I,W,B){if((W.isScene===!0?W.overrideMaterial:null)!==null)return;if(E.state.transmissionRenderTarget[B.id]===void 0){let St=le.has("EXT_color_buffer_half_float")||le.has("EXT_color_buffer_float");E.state.transmissionRenderTarget[B.id]=new pn(1,1,{generateMipmaps:!0,type:St?xn:vn,minFilter:gi,samples:Math.max(4,ce.samples),stencilBuffer:r,resolveDepthBuffer:!1,resolveStencilBuffer:!1,storeMultisampledDepthBuffer:!1,storeMultisampledStencilBuffer:!1,colorSpace:Xt.workingColorSpace})}let dt=E.state.transmissionRenderTarget[B.id],_t=B.viewport||et;dt.setSize(_t.z*D.transmissionResolutionScale,_t.w*D.transmissionResolutionScale);let ht=D.getRenderTarget(),xt=D.getActiveCubeFace(),wt=D.getActiveMipmapLevel();D.setRenderTarget(dt),D.getClearColor(Z),gt=D.getClearAlpha(),gt<1&&D.setClearColor(16777215,.5),D.clear(),Mn&&R.render(W);let Ot=D.toneMapping;D.toneMapping=Zn;let Wt=B.viewport;if(B.viewport!==void 0&&(B.viewport=void 0),E.setupLightsView(B),Me===!0&&j.setGlobalState(D.clippingPlanes,B),xo(S,W,B),Ut.updateMultisampleRenderTarget(dt),Ut.updateRenderTargetMipmap(dt),le.has("WEBGL_multisampled_render_to_texture")===!1){let St=!1;for(let $t=0,_e=I.length;$t<_e;$t++){let re=I[$t],{object:se,geometry:Ge,material:Mt,group:Je}=re;if(Mt.side===en&&se.layers.test(B.layers)){let Zt=Mt.side;Mt.side=Ae,Mt.needsUpdate=!0,md(se,W,B,Ge,Mt,Je),Mt.side=Zt,Mt.needsUpdate=!0,St=!0}}St===!0&&(Ut.updateMultisampleRenderTarget(dt),Ut.updateRenderTargetMipmap(dt))}D.setRenderTarget(ht,xt,wt),D.setClearColor(Z,gt),Wt!==void 0&&(B.viewport=Wt),D.toneMapping=Ot}function xo(S,I,W){let B=I.isScene===!0?I.overrideMaterial:null;for(let z=0,dt=S.length;z<dt;z++){let _t=S[z],{object:ht,geometry:xt,group:wt}=_t,Ot=_t.material;Ot.allowOverride===!0&&B!==null&&(Ot=B),ht.layers.test(W.layers)&&md(ht,I,W,xt,Ot,wt)}}function md(S,I,W,B,z,dt){O!==null&&z.isNodeMaterial&&O.setObject(S,z),S.onBeforeRender(D,I,W,B,z,dt),S.modelViewMatrix.multiplyMatrices(W.matrixWorldInverse,S.matrixWorld),S.normalMatrix.getNormalMatrix(S.modelViewMatrix),z.onBeforeRender(D,I,W,B,S,dt),z.transparent===!0&&z.side===en&&z.forceSinglePass===!1?(z.side=Ae,z.needsUpdate=!0,D.renderBufferDirect(W,I,B,z,S,dt),z.side=zn,z.needsUpdate=!0,D.renderBufferDirect(W,I,B,z,S,dt),z.side=en):D.renderBufferDirect(W,I,B,z,S,dt),S.onAfterRender(D,I,W,B,z,dt)}function gd(S){let I=0;for(let W of S)W.texture!==null&&I++;return I}function nr(S,I,W){I.isScene!==!0&&(I=Sn);let B=Pt.get(S),z=E.state.lights,dt=E.state.shadowsArray,_t=z.state.version,ht=J.getParameters(S,z.state,dt,I,W,E.state.lightProbeGridArray),xt=J.getProgramCacheKey(ht),wt=B.programs;B.environment=S.isMeshStandardMaterial||S.isMeshLambertMaterial||S.isMeshPhongMaterial?I.environment:null,B.fog=I.fog;let Ot=S.isMeshStandardMaterial||S.isMeshLambertMaterial&&!S.envMap||S.isMeshPhongMaterial&&!S.envMap;B.envMap=A.get(S.envMap||B.environment,Ot),B.envMapRotation=B.environment!==null&&S.envMap===null?I.environmentRotation:S.envMapRotation,wt===void 0&&(S.addEventListener("dispose",ee),wt=new Map,B.programs=wt,B.programVariants=new Map);let Wt=wt.get(xt);if(Wt!==void 0){if(B.currentProgram===Wt&&B.lightsStateVersion===_t)return xd(S,ht),Wt}else ht.uniforms=J.getUniforms(S),O!==null&&S.isNodeMaterial&&O.build(S,W,ht),S.onBeforeCompile(ht,D),Wt=J.acquireProgram(ht,xt),wt.set(xt,Wt),B.uniforms=ht.uniforms;let St=B.uniforms;return(!S.isShaderMaterial&&!S.isRawShaderMaterial||S.clipping===!0)&&(St.clippingPlanes=j.uniform),xd(S,ht),B.needsLights=v0(S),B.lightsStateVersion=_t,B.needsLights&&(St.ambientLightColor.value=z.state.ambient,St.lightProbe.value=z.state.probe,St.sunLights.value=z.state.sun,St.sunLightShadows.value=z.state.sunShadow,St.directionalLights.value=z.state.directional,St.directionalLightShadows.value=z.state.directionalShadow,St.spotLights.value=z.state.spot,St.spotLightShadows.value=z.state.spotShadow,St.rectAreaLights.value=z.state.rectArea,St.ltc_1.value=z.state.rectAreaLTC1,St.ltc_2.value=z.state.rectAreaLTC2,St.pointLights.value=z.state.point,St.pointLightShadows.value=z.state.pointShadow,St.hemisphereLights.value=z.state.hemi,St.sunShadowMatrix.value=z.state.sunShadowMatrix,St.sunShadowCascade.value=z.state.sunShadowCascade,St.directionalShadowMatrix.value=z.state.directionalShadowMatrix,St.spotLightMatrix.value=z.state.spotLightMatrix,St.spotLightMap.value=z.state.spotLightMap,St.pointShadowMatrix.value=z.state.pointShadowMatrix),B.numLightProbeGrids=gd(E.state.lightProbeGridArray),B.currentProgram=Wt,B.uniformsList=null,Wt}function p0(S,I,W,B,z){let dt=Pt.get(S),_t=dt.currentProgram.id+","+B+","+z,ht=dt.programVariants.get(_t);return ht===void 0?(ht=nr(S,I,W),dt.programVariants.set(_t,ht)):(dt.currentProgram=ht,dt.uniformsList=null,dt.outputColorSpace=B,dt.toneMapping=z),ht}function vd(S){if(S.uniformsList===null){let I=S.currentProgram.getUniforms();S.uniformsList=Ws.seqWithValue(I.seq,S.uniforms)}return S.uniformsList}function xd(S,I){let W=Pt.get(S);W.outputColorSpace=I.outputColorSpace,W.batching=I.batching,W.batchingColor=I.batchingColor,W.instancing=I.instancing,W.instancingColor=I.instancingColor,W.instancingMorph=I.instancingMorph,W.skinning=I.skinning,W.morphTargets=I.morphTargets,W.morphNormals=I.morphNormals,W.morphColors=I.morphColors,W.morphTargetsCount=I.morphTargetsCount,W.numClippingPlanes=I.numClippingPlanes,W.numIntersection=I.numClipIntersection,W.vertexAlphas=I.vertexAlphas,W.vertexTangents=I.vertexTangents,W.toneMapping=I.toneMapping}function m0(S,I,W,B,z){I.isScene!==!0&&(I=Sn),Ut.resetTextureUnits();let dt=I.fog,_t=B.isMeshStandardMaterial||B.isMeshLambertMaterial||B.isMeshPhongMaterial?I.environment:null,ht=nt===null?D.outputColorSpace:nt.isXRRenderTarget===!0?nt.texture.colorSpace:Xt.workingColorSpace,xt=B.isMeshStandardMaterial||B.isMeshLambertMaterial&&!B.envMap||B.isMeshPhongMaterial&&!B.envMap,wt=A.get(B.envMap||_t,xt),Ot=B.vertexColors===!0&&!!W.attributes.color&&W.attributes.color.itemSize===4,Wt=!!W.attributes.tangent&&(!!B.normalMap||B.anisotropy>0),St=!!W.morphAttributes.position,$t=!!W.morphAttributes.normal,_e=!!W.morphAttributes.color,re=Zn;B.toneMapped&&(nt===null||nt.isXRRenderTarget===!0)&&(re=D.toneMapping);let se=W.morphAttributes.position||W.morphAttributes.normal||W.morphAttributes.color,Ge=se!==void 0?se.length:0,Mt=Pt.get(B),Je=E.state.lights;if(Me===!0&&(rn===!0||S!==Q)){let fe=S===Q&&B.id===$;j.setState(B,S,fe)}let Zt=!1,qi=!1;B.version===Mt.__version?Mt.needsLights&&Mt.lightsStateVersion!==Je.state.version||z.isBatchedMesh&&Mt.batching===!1||!z.isBatchedMesh&&Mt.batching===!0||z.isBatchedMesh&&Mt.batchingColor===!0&&z._colorsTexture===null||z.isBatchedMesh&&Mt.batchingColor===!1&&z._colorsTexture!==null||z.isInstancedMesh&&Mt.instancing===!1||!z.isInstancedMesh&&Mt.instancing===!0||z.isSkinnedMesh&&Mt.skinning===!1||!z.isSkinnedMesh&&Mt.skinning===!0||z.isInstancedMesh&&Mt.instancingColor===!0&&z.instanceColor===null||z.isInstancedMesh&&Mt.instancingColor===!1&&z.instanceColor!==null||z.isInstancedMesh&&Mt.instancingMorph===!0&&z.morphTexture===null||z.isInstancedMesh&&Mt.instancingMorph===!1&&z.morphTexture!==null||Mt.envMap!==wt||B.fog===!0&&Mt.fog!==dt||Mt.numClippingPlanes!==void 0&&(Mt.numClippingPlanes!==j.numPlanes||Mt.numIntersection!==j.numIntersection)||Mt.vertexAlphas!==Ot||Mt.vertexTangents!==Wt||Mt.morphTargets!==St||Mt.morphNormals!==$t||Mt.morphColors!==_e||Mt.morphTargetsCount!==Ge||Mt.numLightProbeGrids!==gd(E.state.lightProbeGridArray)?Zt=!0:(Mt.outputColorSpace!==ht||Mt.toneMapping!==re)&&(qi=!0):(Zt=!0,Mt.__version=B.version);let Ve=Mt.currentProgram;(Zt===!0||qi===!0)&&(Ve=qi===!0?p0(B,I,z,ht,re):nr(B,I,z),O&&B.isNodeMaterial&&O.onUpdateProgram(B,Ve,Mt));let _o=!1,Ai=!1,Yi=!1,Yt=Ve.getUniforms(),Oe=Mt.uniforms;if(pt.useProgram(Ve.program)&&(_o=!0,Ai=!0,Yi=!0),B.id!==$&&($=B.id,Ai=!0),_o||Q!==S){pt.buffers.depth.getReversed()&&S.reversedDepth!==!0&&(S._reversedDepth=!0,S.updateProjectionMatrix()),Yt.setValue(U,"projectionMatrix",S.projectionMatrix),Yt.setValue(U,"viewMatrix",S.matrixWorldInverse);let Le=Yt.map.cameraPosition;Le!==void 0&&Le.setValue(U,qn.setFromMatrixPosition(S.matrixWorld)),ce.logarithmicDepthBuffer&&Yt.setValue(U,"logDepthBufFC",2/(Math.log(S.far+1)/Math.LN2)),(B.isMeshPhongMaterial||B.isMeshToonMaterial||B.isMeshLambertMaterial||B.isMeshBasicMaterial||B.isMeshStandardMaterial||B.isShaderMaterial)&&Yt.setValue(U,"isOrthographic",S.isOrthographicCamera===!0),Q!==S&&(Q=S,Ai=!0,Yi=!0)}if(Mt.needsLights&&(Je.state.sunShadowMap.length>0&&Yt.setValue(U,"sunShadowMap",Je.state.sunShadowMap,Ut),Je.state.directionalShadowMap.length>0&&Yt.setValue(U,"directionalShadowMap",Je.state.directionalShadowMap,Ut),Je.state.spotShadowMap.length>0&&Yt.setValue(U,"spotShadowMap",Je.state.spotShadowMap,Ut),Je.state.pointShadowMap.length>0&&Yt.setValue(U,"pointShadowMap",Je.state.pointShadowMap,Ut)),z.isSkinnedMesh){Yt.setOptional(U,z,"bindMatrix"),Yt.setOptional(U,z,"bindMatrixInverse");let fe=z.skeleton;fe&&(fe.boneTexture===null&&fe.computeBoneTexture(),Yt.setValue(U,"boneTexture",fe.boneTexture,Ut))}z.isBatchedMesh&&(Yt.setOptional(U,z,"batchingTexture"),Yt.setValue(U,"batchingTexture",z._matricesTexture,Ut),Yt.setOptional(U,z,"batchingIdTexture"),Yt.setValue(U,"batchingIdTexture",z._indirectTexture,Ut),Yt.setOptional(U,z,"batchingColorTexture"),z._colorsTexture!==null&&Yt.setValue(U,"batchingColorTexture",z._colorsTexture,Ut));let Dn=W.morphAttributes;if((Dn.position!==void 0||Dn.normal!==void 0||Dn.color!==void 0)&&K.update(z,W,Ve),(Ai||Mt.receiveShadow!==z.receiveShadow)&&(Mt.receiveShadow=z.receiveShadow,Yt.setValue(U,"receiveShadow",z.receiveShadow)),(B.isMeshStandardMaterial||B.isMeshLambertMaterial||B.isMeshPhongMaterial)&&B.envMap===null&&I.environment!==null&&(Oe.envMapIntensity.value=I.environmentIntensity),Oe.dfgLUT!==void 0&&(Oe.dfgLUT.value=RS()),Ai){if(Yt.setValue(U,"toneMappingExposure",D.toneMappingExposure),Mt.needsLights&&g0(Oe,Yi),dt&&B.fog===!0&&ot.refreshFogUniforms(Oe,dt),ot.refreshMaterialUniforms(Oe,B,vt,Rt,E.state.transmissionRenderTarget[S.id]),Mt.needsLights&&Mt.numLightProbeGrids>0){let fe=y,Le=0;for(let ii of E.state.lightProbeGridArray)ii.texture!==null&&(fe.textures[Le]=ii.texture,fe.min[Le]=ii.boundingBox.min,fe.max[Le]=ii.boundingBox.max,fe.resolution[Le]=ii.resolution,Le++);for(let ii in fe)fe[ii].length=Le;Oe.probesSH.value=fe.textures,Oe.probesMin.value=fe.min,Oe.probesMax.value=fe.max,Oe.probesResolution.value=fe.resolution}Ws.upload(U,vd(Mt),Oe,Ut)}if(B.isShaderMaterial&&B.uniformsNeedUpdate===!0&&(Ws.upload(U,vd(Mt),Oe,Ut),B.uniformsNeedUpdate=!1),B.isSpriteMaterial&&Yt.setValue(U,"center",z.center),Yt.setValue(U,"modelViewMatrix",z.modelViewMatrix),Yt.setValue(U,"normalMatrix",z.normalMatrix),Yt.setValue(U,"modelMatrix",z.matrixWorld),B.uniformsGroups!==void 0){let fe=B.uniformsGroups;for(let Le=0,ii=fe.length;Le<ii;Le++){let yd=fe[Le];Et.update(yd,Ve),Et.bind(yd,Ve)}}return Ve}function g0(S,I){S.ambientLightColor.needsUpdate=I,S.lightProbe.needsUpdate=I,S.sunLights.needsUpdate=I,S.sunLightShadows.needsUpdate=I,S.directionalLights.needsUpdate=I,S.directionalLightShadows.needsUpdate=I,S.pointLights.needsUpdate=I,S.pointLightShadows.needsUpdate=I,S.spotLights.needsUpdate=I,S.spotLightShadows.needsUpdate=I,S.rectAreaLights.needsUpdate=I,S.hemisphereLights.needsUpdate=I}function v0(S){return S.isMeshLambertMaterial||S.isMeshToonMaterial||S.isMeshPhongMaterial||S.isMeshStandardMaterial||S.isShadowMaterial||S.isShaderMaterial&&S.lights===!0}this.getActiveCubeFace=function(){return X},this.getActiveMipmapLevel=function(){return G},this.getRenderTarget=function(){return nt},this.setRenderTargetTextures=function(S,I,W){let B=Pt.get(S);B.__autoAllocateDepthBuffer=S.resolveDepthBuffer===!1,B.__autoAllocateDepthBuffer===!1&&(B.__useRenderToTexture=!1),Pt.get(S.texture).__webglTexture=I,Pt.get(S.depthTexture).__webglTexture=B.__autoAllocateDepthBuffer?void 0:W,B.__hasExternalTextures=!0},this.setRenderTargetFramebuffer=function(S,I){let W=Pt.get(S);W.__webglFramebuffer=I,W.__useDefaultFramebuffer=I===void 0},this.setRenderTarget=function(S,I=0,W=0){nt=S,X=I,G=W;let B=null,z=!1,dt=!1;if(S){let ht=Pt.get(S);if(ht.__useDefaultFramebuffer!==void 0){pt.bindFramebuffer(U.FRAMEBUFFER,ht.__webglFramebuffer),et.copy(S.viewport),yt.copy(S.scissor),Dt=S.scissorTest,pt.viewport(et),pt.scissor(yt),pt.setScissorTest(Dt),$=-1;return}else if(ht.__webglFramebuffer===void 0)Ut.setupRenderTarget(S);else if(ht.__hasExternalTextures)Ut.rebindTextures(S,Pt.get(S.texture).__webglTexture,Pt.get(S.depthTexture).__webglTexture);else if(S.depthBuffer){let Ot=S.depthTexture;if(ht.__boundDepthTexture!==Ot){if(Ot!==null&&Pt.has(Ot)&&(S.width!==Ot.image.width||S.height!==Ot.image.height))throw new Error("THREE.WebGLRenderer: Attached DepthTexture is initialized to the incorrect size.");Ut.setupDepthRenderbuffer(S)}}let xt=S.texture;(xt.isData3DTexture||xt.isDataArrayTexture||xt.isCompressedArrayTexture)&&(dt=!0);let wt=Pt.get(S).__webglFramebuffer;S.isWebGLCubeRenderTarget?(Array.isArray(wt[I])?B=wt[I][W]:B=wt[I],z=!0):S.samples>0&&Ut.useMultisampledRTT(S)===!1?B=Pt.get(S).__webglMultisampledFramebuffer:Array.isArray(wt)?B=wt[W]:B=wt,et.copy(S.viewport),yt.copy(S.scissor),Dt=S.scissorTest}else et.copy(It).multiplyScalar(vt).floor(),yt.copy(te).multiplyScalar(vt).floor(),Dt=ie;if(W!==0&&(B=V),pt.bindFramebuffer(U.FRAMEBUFFER,B)&&pt.drawBuffers(S,B),pt.viewport(et),pt.scissor(yt),pt.setScissorTest(Dt),z){let ht=Pt.get(S.texture);U.framebufferTexture2D(U.FRAMEBUFFER,U.COLOR_ATTACHMENT0,U.TEXTURE_CUBE_MAP_POSITIVE_X+I,ht.__webglTexture,W)}else if(dt){let ht=I;for(let xt=0;xt<S.textures.length;xt++){let wt=Pt.get(S.textures[xt]);U.framebufferTextureLayer(U.FRAMEBUFFER,U.COLOR_ATTACHMENT0+xt,wt.__webglTexture,W,ht)}}else if(S!==null&&W!==0){let ht=Pt.get(S.texture);U.framebufferTexture2D(U.FRAMEBUFFER,U.COLOR_ATTACHMENT0,U.TEXTURE_2D,ht.__webglTexture,W)}$=-1};function _d(S){let I=Pt.get(S);return(I.__readFormat!==S.format||I.__readType!==S.type)&&(I.__readFormat=S.format,I.__readType=S.type,I.__formatReadable=ce.textureFormatReadable(S.format),I.__typeReadable=ce.textureTypeReadable(S.type)),I}this.readRenderTargetPixels=function(S,I,W,B,z,dt,_t,ht=0){if(!(S&&S.isWebGLRenderTarget)){Lt("WebGLRenderer.readRenderTargetPixels: renderTarget is not THREE.WebGLRenderTarget.");return}let xt=Pt.get(S).__webglFramebuffer;if(S.isWebGLCubeRenderTarget&&_t!==void 0&&(xt=xt[_t],Array.isArray(xt)&&(xt=xt[0])),xt){pt.bindFramebuffer(U.FRAMEBUFFER,xt);try{let wt=S.textures[ht],Ot=wt.format,Wt=wt.type;S.textures.length>1&&U.readBuffer(U.COLOR_ATTACHMENT0+ht);let St=_d(wt);if(St.__formatReadable===!1){Lt("WebGLRenderer.readRenderTargetPixels: renderTarget is not in RGBA or implementation defined format.");return}if(St.__typeReadable===!1){Lt("WebGLRenderer.readRenderTargetPixels: renderTarget is not in UnsignedByteType or implementation defined type.");return}I>=0&&I<=S.width-B&&W>=0&&W<=S.height-z&&U.readPixels(I,W,B,z,rt.convert(Ot),rt.convert(Wt),dt)}finally{let wt=nt!==null?Pt.get(nt).__webglFramebuffer:null;pt.bindFramebuffer(U.FRAMEBUFFER,wt)}}},this.readRenderTargetPixelsAsync=async function(S,I,W,B,z,dt,_t,ht=0){if(!(S&&S.isWebGLRenderTarget))throw new Error("THREE.WebGLRenderer.readRenderTargetPixels: renderTarget is not THREE.WebGLRenderTarget.");let xt=Pt.get(S).__webglFramebuffer;if(S.isWebGLCubeRenderTarget&&_t!==void 0&&(xt=xt[_t],Array.isArray(xt)&&(xt=xt[0])),xt)if(I>=0&&I<=S.width-B&&W>=0&&W<=S.height-z){pt.bindFramebuffer(U.FRAMEBUFFER,xt);let wt=S.textures[ht],Ot=wt.format,Wt=wt.type;S.textures.length>1&&U.readBuffer(U.COLOR_ATTACHMENT0+ht);let St=_d(wt);if(St.__formatReadable===!1)throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: renderTarget is not in RGBA or implementation defined format.");if(St.__typeReadable===!1)throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: renderTarget is not in UnsignedByteType or implementation defined type.");let $t=U.createBuffer();U.bindBuffer(U.PIXEL_PACK_BUFFER,$t),U.bufferData(U.PIXEL_PACK_BUFFER,dt.byteLength,U.STREAM_READ),U.readPixels(I,W,B,z,rt.convert(Ot),rt.convert(Wt),0),U.bindBuffer(U.PIXEL_PACK_BUFFER,null);let _e=nt!==null?Pt.get(nt).__webglFramebuffer:null;pt.bindFramebuffer(U.FRAMEBUFFER,_e);let re=U.fenceSync(U.SYNC_GPU_COMMANDS_COMPLETE,0);return U.flush(),await Qf(U,re,4),U.bindBuffer(U.PIXEL_PACK_BUFFER,$t),U.getBufferSubData(U.PIXEL_PACK_BUFFER,0,dt),U.bindBuffer(U.PIXEL_PACK_BUFFER,null),U.deleteBuffer($t),U.deleteSync(re),dt}else throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: requested read bounds are out of range.")},this.copyFramebufferToTexture=function(S,I=null,W=0){let B=Math.pow(2,-W),z=Math.floor(S.image.width*B),dt=Math.floor(S.image.height*B),_t=I!==null?I.x:0,ht=I!==null?I.y:0;Ut.setTexture2D(S,0),U.copyTexSubImage2D(U.TEXTURE_2D,W,0,0,_t,ht,z,dt),pt.unbindTexture()},this.copyTextureToTexture=function(S,I,W=null,B=null,z=0,dt=0){let _t,ht,xt,wt,Ot,Wt,St,$t,_e,re=S.isCompressedTexture?S.mipmaps[dt]:S.image;if(W!==null)_t=W.max.x-W.min.x,ht=W.max.y-W.min.y,xt=W.isBox3?W.max.z-W.min.z:1,wt=W.min.x,Ot=W.min.y,Wt=W.isBox3?W.min.z:0;else{let Yt=Math.pow(2,-z);_t=Math.floor(re.width*Yt),ht=Math.floor(re.height*Yt),S.isDataArrayTexture?xt=re.depth:S.isData3DTexture?xt=Math.floor(re.depth*Yt):xt=1,wt=0,Ot=0,Wt=0}B!==null?(St=B.x,$t=B.y,_e=B.z):(St=0,$t=0,_e=0);let se=rt.convert(I.format),Ge=rt.convert(I.type),Mt;I.isData3DTexture?(Ut.setTexture3D(I,0),Mt=U.TEXTURE_3D):I.isDataArrayTexture||I.isCompressedArrayTexture?(Ut.setTexture2DArray(I,0),Mt=U.TEXTURE_2D_ARRAY):(Ut.setTexture2D(I,0),Mt=U.TEXTURE_2D),pt.activeTexture(U.TEXTURE0),pt.pixelStorei(U.UNPACK_FLIP_Y_WEBGL,I.flipY),pt.pixelStorei(U.UNPACK_PREMULTIPLY_ALPHA_WEBGL,I.premultiplyAlpha),pt.pixelStorei(U.UNPACK_ALIGNMENT,I.unpackAlignment);let Je=pt.getParameter(U.UNPACK_ROW_LENGTH),Zt=pt.getParameter(U.UNPACK_IMAGE_HEIGHT),qi=pt.getParameter(U.UNPACK_SKIP_PIXELS),Ve=pt.getParameter(U.UNPACK_SKIP_ROWS),_o=pt.getParameter(U.UNPACK_SKIP_IMAGES);pt.pixelStorei(U.UNPACK_ROW_LENGTH,re.width),pt.pixelStorei(U.UNPACK_IMAGE_HEIGHT,re.height),pt.pixelStorei(U.UNPACK_SKIP_PIXELS,wt),pt.pixelStorei(U.UNPACK_SKIP_ROWS,Ot),pt.pixelStorei(U.UNPACK_SKIP_IMAGES,Wt);let Ai=S.isDataArrayTexture||S.isData3DTexture,Yi=I.isDataArrayTexture||I.isData3DTexture;if(S.isDepthTexture){let Yt=Pt.get(S),Oe=Pt.get(I),Dn=Pt.get(Yt.__renderTarget),fe=Pt.get(Oe.__renderTarget);pt.bindFramebuffer(U.READ_FRAMEBUFFER,Dn.__webglFramebuffer),pt.bindFramebuffer(U.DRAW_FRAMEBUFFER,fe.__webglFramebuffer);for(let Le=0;Le<xt;Le++)Ai&&(U.framebufferTextureLayer(U.READ_FRAMEBUFFER,U.COLOR_ATTACHMENT0,Pt.get(S).__webglTexture,z,Wt+Le),U.framebufferTextureLayer(U.DRAW_FRAMEBUFFER,U.COLOR_ATTACHMENT0,Pt.get(I).__webglTexture,dt,_e+Le)),U.blitFramebuffer(wt,Ot,wt+_t,Ot+ht,St,$t,St+_t,$t+ht,U.DEPTH_BUFFER_BIT,U.NEAREST);pt.bindFramebuffer(U.READ_FRAMEBUFFER,null),pt.bindFramebuffer(U.DRAW_FRAMEBUFFER,null)}else if(z!==0||S.isRenderTargetTexture||Pt.has(S)){let Yt=Pt.get(S),Oe=Pt.get(I);pt.bindFramebuffer(U.READ_FRAMEBUFFER,C),pt.bindFramebuffer(U.DRAW_FRAMEBUFFER,H);for(let Dn=0;Dn<xt;Dn++)Ai?U.framebufferTextureLayer(U.READ_FRAMEBUFFER,U.COLOR_ATTACHMENT0,Yt.__webglTexture,z,Wt+Dn):U.framebufferTexture2D(U.READ_FRAMEBUFFER,U.COLOR_ATTACHMENT0,U.TEXTURE_2D,Yt.__webglTexture,z),Yi?U.framebufferTextureLayer(U.DRAW_FRAMEBUFFER,U.COLOR_ATTACHMENT0,Oe.__webglTexture,dt,_e+Dn):U.framebufferTexture2D(U.DRAW_FRAMEBUFFER,U.COLOR_ATTACHMENT0,U.TEXTURE_2D,Oe.__webglTexture,dt),z!==0?U.blitFramebuffer(wt,Ot,wt+_t,Ot+ht,St,$t,St+_t,$t+ht,U.COLOR_BUFFER_BIT,U.NEAREST):Yi?U.copyTexSubImage3D(Mt,dt,St,$t,_e+Dn,wt,Ot,_t,ht):U.copyTexSubImage2D(Mt,dt,St,$t,wt,Ot,_t,ht);pt.bindFramebuffer(U.READ_FRAMEBUFFER,null),pt.bindFramebuffer(U.DRAW_FRAMEBUFFER,null)}else Yi?S.isDataTexture||S.isData3DTexture?U.texSubImage3D(Mt,dt,St,$t,_e,_t,ht,xt,se,Ge,re.data):I.isCompressedArrayTexture?U.compressedTexSubImage3D(Mt,dt,St,$t,_e,_t,ht,xt,se,re.data):U.texSubImage3D(Mt,dt,St,$t,_e,_t,ht,xt,se,Ge,re):S.isDataTexture?U.texSubImage2D(U.TEXTURE_2D,dt,St,$t,_t,ht,se,Ge,re.data):S.isCompressedTexture?U.compressedTexSubImage2D(U.TEXTURE_2D,dt,St,$t,re.width,re.height,se,re.data):U.texSubImage2D(U.TEXTURE_2D,dt,St,$t,_t,ht,se,Ge,re);pt.pixelStorei(U.UNPACK_ROW_LENGTH,Je),pt.pixelStorei(U.UNPACK_IMAGE_HEIGHT,Zt),pt.pixelStorei(U.UNPACK_SKIP_PIXELS,qi),pt.pixelStorei(U.UNPACK_SKIP_ROWS,Ve),pt.pixelStorei(U.UNPACK_SKIP_IMAGES,_o),dt===0&&I.generateMipmaps===!0&&I.mipmapsAutoUpdate===!0&&U.generateMipmap(Mt),pt.unbindTexture()},this.initRenderTarget=function(S){Pt.get(S).__webglFramebuffer===void 0&&Ut.setupRenderTarget(S)},this.initTexture=function(S){S.isCubeTexture?Ut.setTextureCube(S,0):S.isData3DTexture?Ut.setTexture3D(S,0):S.isDataArrayTexture||S.isCompressedArrayTexture?Ut.setTexture2DArray(S,0):Ut.setTexture2D(S,0),pt.unbindTexture()},this.resetState=function(){X=0,G=0,nt=null,pt.reset(),at.reset()}}get coordinateSystem(){return Tn}get outputColorSpace(){return this._outputColorSpace}set outputColorSpace(t){this._outputColorSpace=t;let e=this.getContext();e.drawingBufferColorSpace=Xt._getDrawingBufferColorSpace(t),e.unpackColorSpace=Xt._getUnpackColorSpace()}};var El={x:44,y:22},zp=.4;function Tl(i){let t=L("slice-value");t.closest("[hidden]")===null&&Hp(t.valueAsNumber+i*Number(t.step))}function Hp(i){let t=L("slice-value"),e=t.max==="360";t.value=String(e?(i%360+360)%360:i),t.dispatchEvent(new Event("input"))}var Al=class{handle=L("plane-handle");opposite=L("plane-opposite");placeOf=null;oppositePlace=()=>[0,0];value=0;constructor(t){let{handle:e}=this,n=null,s=[0,0];e.addEventListener("pointerdown",r=>{e.setPointerCapture(r.pointerId),n=this.value,s=[r.clientX,r.clientY]}),e.addEventListener("pointermove",r=>{n===null||this.placeOf===null||(n+=this.along([r.clientX-s[0],r.clientY-s[1]]),s=[r.clientX,r.clientY],Hp(n))});for(let r of["pointerup","pointercancel"])e.addEventListener(r,()=>n=null);e.addEventListener("keydown",r=>{let o={ArrowUp:1,ArrowRight:1,ArrowDown:-1,ArrowLeft:-1,PageUp:5,PageDown:-5}[r.key];o!==void 0&&(r.preventDefault(),Tl(o))}),t.on(["camera"],()=>this.draw()),new ResizeObserver(()=>this.draw()).observe(L("stage"))}show(t,e,n){let{min:s,max:r,valueAsNumber:o}=L("slice-value");this.value=o,this.placeOf=t,this.handle.hidden=!1,L("plane-text").textContent=e;let a={valuemin:s,valuemax:r,valuenow:String(o),valuetext:e};for(let[l,c]of Object.entries(a))this.handle.setAttribute(`aria-${l}`,c);this.opposite.hidden=n===void 0,n!==void 0&&(this.opposite.textContent=n.text,this.oppositePlace=n.place),this.draw()}hide(){this.placeOf=null,this.handle.hidden=this.opposite.hidden=!0}draw(){if(this.placeOf===null)return;let{clientWidth:t,clientHeight:e}=L("stage"),n=(o,[a,l])=>{o.style.left=`${Math.min(Math.max(a,El.x),t-El.x)}px`,o.style.top=`${Math.min(Math.max(l,El.y),e-El.y)}px`};n(this.handle,this.placeOf(this.value)),n(this.opposite,this.oppositePlace());let[s,r]=this.way();L("plane-arrow").style.rotate=`${Math.atan2(r,s)}rad`}way(){let[t,e]=[this.placeOf(this.value),this.placeOf(this.value+1)];return[e[0]-t[0],e[1]-t[1]]}along([t,e]){let[n,s]=this.way(),r=L("slice-value"),o=zp*L("stage").clientHeight/(2*(Number(r.max)-Number(r.min)));return Math.hypot(n,s)<o&&([n,s]=[0,-o/zp]),(t*n+e*s)/(n*n+s*s)}};var ge=globalThis.matchMedia?.("(color-gamut: p3)").matches?"display-p3":"srgb",Gp=.005;function Vp(i){let t=new Float32Array(i.length/3);for(let e=0;e<i.length;e++){let n=Math.floor(e/3);t[n]=Math.max(t[n],-i[e],i[e]-1)}return t}function Jr(i){let t=i<=.0031308?12.92*i:1.055*i**.4166666666666667-.055;return Math.min(Math.max(t,0),1)}function Jn(i,t=ge){let e=Array.from(i,Jr);return t==="display-p3"?`color(display-p3 ${e.map(n=>n.toFixed(4)).join(" ")})`:`rgb(${e.map(n=>Math.round(255*n)).join(" ")})`}function Wp(i,t){return[Math.hypot(i,t),(Math.atan2(t,i)*180/Math.PI+360)%360]}var PS={CIEXYZ:.2,Oklab:.2,IPT:.2,ICtCp:.2,ITP:100,Jzazbz:.04},$p=1.2;function Xp(i,t){return{axis:t[0]==="X"?1:0,lightness:PS[i]??20}}function Rl(i,t){let{onBeforeCompile:e}=i,n=i.customProgramCacheKey();i.onBeforeCompile=(s,r)=>{e.call(i,s,r),t(s)},i.customProgramCacheKey=()=>n+String(t)}var IS=`
varying vec3 vRaw;
uniform vec3 lineColour;
uniform float lineOpacity, lineWidth, lightnessStep;
uniform int lightnessAxis;

/** How much of a pixel a line has. Values are in steps; lines that are too dense fade. */
float lineShare(float value, float perPixel) {
  float distance = abs(fract(value - 0.5) - 0.5) / max(perPixel, 1e-6);
  return clamp(0.5 * lineWidth + 0.5 - distance, 0.0, 1.0) * (1.0 - smoothstep(0.05, 0.2, perPixel / lineWidth));
}

float lines(vec3 raw) {
  float lightness = raw[lightnessAxis] / lightnessStep;
  return lineShare(lightness, length(vec2(dFdx(lightness), dFdy(lightness))));
}
`,Cl=class{colour=new Gt;uniforms={lineColour:{value:this.colour},lineWidth:{value:$p},lightnessStep:{value:10},lightnessAxis:{value:0}};set steps({axis:t,lightness:e}){this.uniforms.lightnessAxis.value=t,this.uniforms.lightnessStep.value=e}fit(t){this.uniforms.lineWidth.value=$p*t.getPixelRatio()}addTo(t,e){Rl(t,n=>{Object.assign(n.uniforms,this.uniforms,{lineOpacity:e}),n.vertexShader=n.vertexShader.replace("#include <common>",`#include <common>
varying vec3 vRaw;`).replace("#include <begin_vertex>",`#include <begin_vertex>
vRaw = position;`),n.fragmentShader=n.fragmentShader.replace("#include <common>",`#include <common>
${IS}`).replace("#include <opaque_fragment>",`float line = lineOpacity * lines(vRaw);
          float share = line + diffuseColor.a * (1.0 - line);
          outgoingLight = mix(outgoingLight, lineColour, line / max(share, 1e-6));
          diffuseColor.a = share;
          #include <opaque_fragment>`)})}};var LS="vec3(-0.3, 0.5, 1.0)",DS=.72,NS=`
diffuseColor.rgb *= clamp(vColor.rgb, 0.0, 1.0);
vec3 faceNormal = normalize(cross(dFdx(vViewPosition), dFdy(vViewPosition)));
diffuseColor.rgb *= mix(${DS}, 1.0, clamp(dot(faceNormal, ${LS}), 0.0, 1.0));
`;function Pl(i={}){let t=new Cn({vertexColors:!0,...i});return t.onBeforeCompile=US,t}function US(i){i.vertexShader=i.vertexShader.replace("void main() {",`varying vec3 vViewPosition;
void main() {`).replace("#include <project_vertex>",`#include <project_vertex>
vViewPosition = -mvPosition.xyz;`),i.fragmentShader=i.fragmentShader.replace("void main() {",`varying vec3 vViewPosition;
void main() {`).replace("#include <color_fragment>",NS)}function yn(i){return i[0]==="X"?new jt:new jt().set(0,1,0,0,1,0,0,0,0,0,-1,0,0,0,0,1)}var gu={polygonOffset:!0,polygonOffsetFactor:1,polygonOffsetUnits:1},FS=8192,OS=.08,qp={far:.12,near:.4},BS=1.5,kS=1,zS=2,Yp=10,jp=20,Il=class{lines=new Cl;surface=Pl(gu);grey=Pl(gu);edge=new mn({transparent:!0,color:0,opacity:.35});far=this.shell(Ae,qp.far);near=this.shell(zn,qp.near);covered=HS();rims=Jp.map(([t,e])=>GS(t,e));countFar=Zp(Ae);countNear=Zp(zn);constructor(){Kp(this.surface,!1),Kp(this.grey,!0),Object.assign(this.grey,{depthFunc:Cs,stencilWrite:!0,stencilFunc:vl})}set clippingPlanes(t){let{surface:e,grey:n,edge:s,far:r,near:o,covered:a,rims:l}=this;for(let c of[e,n,s,r,o,a,...l])c.clippingPlanes=t}setShellOpacity(t){this.far.opacity=this.near.opacity=t}shell(t,e){let n=Pl({transparent:!0,depthWrite:!1,side:t});return this.lines.addTo(n,{value:e}),n}};function Zp(i){return new Cn({side:i,colorWrite:!1,depthWrite:!1,stencilWrite:!0,stencilZFail:i===Ae?$h:Xh,...gu})}var Jp=Array.from({length:8},(i,t)=>[Math.cos(t*Math.PI/4),Math.sin(t*Math.PI/4)]);function HS(){return new Cn({side:en,colorWrite:!1,depthWrite:!1,depthTest:!1,transparent:!0,stencilWrite:!0,stencilRef:1,stencilZPass:Wh})}function GS(i,t){let e=new Cn({side:en,depthWrite:!1,transparent:!0,stencilWrite:!0,stencilRef:1,stencilFunc:vl});return Rl(e,n=>{n.uniforms.beside={value:e.userData.beside},n.vertexShader=n.vertexShader.replace("#include <common>",`#include <common>
uniform vec2 beside;`).replace("#include <project_vertex>",`#include <project_vertex>
gl_Position.xy += beside * gl_Position.w;`)}),e.userData.beside=new Ct,e.userData.step=[i,t],e}function Kp(i,t){Rl(i,e=>{e.uniforms.isGrey={value:t},e.fragmentShader=e.fragmentShader.replace("#include <common>",`#include <common>
uniform bool isGrey;`).replace("#include <opaque_fragment>",`if (isGrey) outgoingLight = vec3(0.12 + 0.25 * dot(outgoingLight, vec3(0.2126, 0.7152, 0.0722)));
        #include <opaque_fragment>`)})}var Ll=class{constructor(t,e,n,s,r,o,a,l){this.steps=r;this.wanted=o;this.materials=a;this.events=l;this.group.applyMatrix4(yn(s)),this.group.add(this.mesh,this.edges,this.far,this.near,this.grey,...this.counts,this.covered,...this.rims);for(let c of this.group.children)Object.assign(c,{frustumCulled:!1,visible:!1});for(let c of[this.far,this.near])c.onBeforeRender=h=>this.materials.lines.fit(h);this.rims.forEach((c,h)=>{c.onBeforeRender=d=>this.placeRim(d,h)}),this.rims.at(-1).onAfterRender=c=>c.clearStencil(),this.grey.renderOrder=zS,this.grey.onAfterRender=c=>c.clearStencil();for(let c of this.counts)c.renderOrder=kS;this.worker=new Worker(t),this.worker.onmessage=({data:c})=>this.receive(c),this.worker.onerror=()=>l.failed("The reader of histories could not be loaded."),this.order({kind:"open",source:e,space:n,screen:ge})}steps;wanted;materials;events;group=new Ne;level=null;available=0;bytes=0;worker;surface=new he;lines=new he;mesh=new me(this.surface);edges=new Rn(this.lines);far=new me(this.surface);near=new me(this.surface);grey=new me(this.surface);counts=[new me(this.surface),new me(this.surface)];covered=new me(this.surface);rims=Jp.map(()=>new me(this.surface));look={isVisible:!1,opacity:1,hasEdges:!1};capacity=0;busy=!1;shown=0;setTriangles(t){this.wanted=t,this.ask()}setLook(t,e,n){let s=t.isVisible&&t.opacity===1,r=t.isVisible&&t.opacity<1;this.look=t,this.materials=n,this.mesh.visible=s,this.mesh.material=n.surface,this.grey.material=n.grey,this.grey.visible&&=s,this.edges.visible=s&&t.hasEdges,this.edges.material=n.edge,this.far.material=n.far,this.near.material=n.near,this.covered.material=n.covered;for(let o of[this.far,this.near,this.covered,...this.rims])o.visible=r;this.rims.forEach((o,a)=>o.material=n.rims[a]);for(let o of n.rims)o.color.set(e);[this.counts[0].material,this.counts[1].material]=[n.countFar,n.countNear],this.setCounted(this.counts[0].visible),n.lines.colour.set(e),n.lines.steps=this.steps}setRank(t){this.far.renderOrder=Yp-t,this.near.renderOrder=Yp+1+t,this.covered.renderOrder=jp+2*t;for(let e of this.rims)e.renderOrder=jp+2*t+1}placeRim(t,e){let n=this.materials.rims[e],[s,r]=n.userData.step,{width:o,height:a}=t.getDrawingBufferSize(new Ct),l=2*BS*t.getPixelRatio();n.userData.beside.set(l*s/o,l*r/a)}clip(t){this.materials.clippingPlanes=t}setGrey(t){this.grey.visible=t&&this.mesh.visible}setCounted(t){for(let e of this.counts)e.visible=t;this.materials.setShellOpacity(t?Math.min(OS,this.look.opacity):this.look.opacity)}get targets(){return{solid:this.mesh.visible?[this.mesh]:[],shell:this.near.visible?[this.near]:[]}}get isVisible(){return this.look.isVisible}dispose(){this.worker.onmessage=this.worker.onerror=null,this.worker.terminate(),this.group.removeFromParent(),this.surface.dispose(),this.lines.dispose()}receive(t){if(t.kind==="failed"){this.events.failed(t.message);return}if(t.kind==="received"){this.available=t.available,this.bytes=t.bytes,this.events.received(t.complete),t.complete&&(this.shown=0),this.ask();return}this.busy=!1,this.upload(t.level),this.ask(),this.events.level()}ask(){let t=Math.min(this.wanted,this.available);this.busy||this.available===0||t===this.shown||(this.busy=!0,this.shown=t,this.order({kind:"level",triangles:t}))}order(t){this.worker.postMessage(t)}upload(t){this.level=t;let e=t.positions.length/3,n=Math.max(FS,2**Math.ceil(Math.log2(e)));(n>this.capacity||n<this.capacity/2)&&this.allocate(n);let s=(r,o)=>{r.array.set(o),r.clearUpdateRanges(),r.addUpdateRange(0,o.length),r.needsUpdate=!0};s(this.surface.getAttribute("position"),t.positions),s(this.surface.getAttribute("color"),t.colours),s(this.surface.index,t.faces),s(this.lines.index,t.edges),this.surface.setDrawRange(0,t.faces.length),this.lines.setDrawRange(0,t.edges.length),this.surface.boundingSphere=VS(t.positions)}allocate(t){this.capacity=t;let e=2*t;this.surface.dispose(),this.lines.dispose();let n=new qe(new Float32Array(3*t),3);this.surface.setAttribute("position",n),this.surface.setAttribute("color",new qe(new Float32Array(3*t),3)),this.surface.setIndex(new qe(new Uint32Array(3*e),1)),this.lines.setAttribute("position",n),this.lines.setIndex(new qe(new Uint32Array(3*e),1))}};function VS(i){let t=new P(1/0,1/0,1/0),e=t.clone().negate(),n=new P;for(let r=0;r<i.length;r+=3)n.fromArray(i,r),t.min(n),e.max(n);let s=t.clone().add(e).divideScalar(2);return new ln(s,e.distanceTo(t)/2)}var Qr=[.9642,1,.8249],im=[.3127/.329,1,(1-.3127-.329)/.329],sm={srgb:[.64,.33,.3,.6,.15,.06],"display-p3":[.68,.32,.265,.69,.15,.06],bt2020:[.708,.292,.17,.797,.131,.046]},Dl={Bradford:[.8951,.2664,-.1614,-.7502,1.7135,.0367,.0389,-.0685,1.0296],CAT02:[.7328,.4296,-.1624,-.7036,1.6975,.0061,.003,.0136,.9834],CAT16:[.401288,.650173,-.051461,-.250268,1.204414,.045854,-.002079,.048952,.953127],"von-Kries":[.40024,.7076,-.08081,-.2263,1.16532,.0457,0,0,.91822],"XYZ-scaling":[1,0,0,0,1,0,0,0,1]};function yi(i,t){let e=t[0],n=t[1],s=t[2];t[0]=i[0]*e+i[1]*n+i[2]*s,t[1]=i[3]*e+i[4]*n+i[5]*s,t[2]=i[6]*e+i[7]*n+i[8]*s}function Xs(i,t){return i>0?Math.exp(t*Math.log(i)):0}function to(i,t){let e=Float64Array.from(t);return yi(i,e),e}function qs(i,t){return Array.from({length:9},(e,n)=>{let[s,r]=[n-n%3,n%3];return i[s]*t[r]+i[s+1]*t[r+3]+i[s+2]*t[r+6]})}function Vn(i){let t=n=>{let[s,r]=[Math.floor(n/3),n%3],o=(a,l)=>i[3*((s+a)%3)+(r+l)%3];return o(1,1)*o(2,2)-o(1,2)*o(2,1)},e=i[0]*t(0)+i[1]*t(1)+i[2]*t(2);return i.map((n,s)=>t(3*(s%3)+Math.floor(s/3))/e)}function xu(i,t){return t.map((e,n)=>e*i[Math.floor(n/3)])}function rm(i,t,e){let[n,s]=[to(e,i),to(e,t)];return qs(Vn(e),xu(s.map((r,o)=>r/n[o]),e))}function om([i,t,e,n,s,r]){let o=(c,h)=>(1-c-h)/h,a=[i/t,e/n,s/r,1,1,1,o(i,t),o(e,n),o(s,r)],l=to(Vn(a),im);return a.map((c,h)=>c*l[h%3])}function Qp(i){let t=rm(im,Qr,Dl.Bradford);return Vn(qs(t,om(sm[i])))}var WS={srgb:Qp("srgb"),"display-p3":Qp("display-p3")};function am([i,t,e]){let n=s=>s>.20689655172413793?s*s*s:(s-.13793103448275862)*108/841;return s=>{let r=(s[0]+16)/116,[o,a]=[r+s[1]/500,r-s[2]/200];s[0]=i*n(o),s[1]=t*n(r),s[2]=e*n(a)}}function $S([i,t,e]){let n=i+15*t+3*e,[s,r]=[4*i/n,9*t/n];return o=>{let a=o[0];if(!(a>0)){o.fill(0);return}let l=o[1]/(13*a)+s,c=Math.max(o[2]/(13*a)+r,1e-4),h=t*(a>8?((a+16)/116)**3:a*(3/29)**3);o[0]=h*9*l/(4*c),o[1]=h,o[2]=h*(12-3*l-20*c)/(4*c)}}function XS(i){let[t,e]=[Math.cos(26*Math.PI/180),Math.sin(26*Math.PI/180)],n=100/Math.log1p(.39),s=am(i);return r=>{let o=Math.sqrt(r[1]*r[1]+r[2]*r[2]),a=Math.expm1(.0435*Math.min(o,200))/.075,[l,c]=o>0?[r[1]/o,r[2]/o]:[1,0],h=a*(l*t+c*e),d=a*(c*t-l*e)/.83;r[0]=Math.expm1(Math.min(Math.max(r[0],0),200)/n)/.0039,r[1]=h*t-d*e,r[2]=h*e+d*t,s(r)}}function lm(i,t,e){let[n,s]=[Vn(e),Vn(i)];return r=>{yi(n,r);for(let o=0;o<3;o++)r[o]=Math.sign(r[o])*Xs(Math.abs(r[o]),1/t);yi(s,r)}}var qS=lm([.8189330101,.3618667424,-.1288597137,.0329845436,.9293118715,.0361456387,.0482003018,.2643662691,.633851707],1/3,[.2104542553,.793617785,-.0040720468,1.9779984951,-2.428592205,.4505937099,.0259040371,.7827717662,-.808675766]),YS=lm([.4002,.7075,-.0807,-.228,1.15,.0612,0,0,.9184],.43,[.4,.4,.2,4.455,-4.851,.396,.8056,.3572,-1.1628]);function cm(i,t){let[e,n,s]=[.8359375,18.8515625,18.6875],r=Math.min(Xs(i,1/t),1.0075);return 1e4*Xs((r-e)/(n-s*r),16384/2610)}function tm(i,t){let e=[1688,2146,262,683,2951,462,99,309,3688].map(o=>o/4096),n=[2048,2048,0,6610,-13613,7003,17933,-17390,-543].map(o=>o/4096),s=Vn(t?xu([720,360,720],n):n),r=qs(om(sm.bt2020),Vn(e));return o=>{yi(s,o);for(let a=0;a<3;a++)o[a]=cm(o[a],2523/4096*128)/i;yi(r,o)}}function jS(i){let[t,e,n,s]=[1.15,.66,-.56,16295499532821565e-27],r=Vn([.5,.5,0,3.524,-4.066708,.542708,.199076,1.096799,-1.295875]),o=Vn([.41478972,.579999,.014648,-.20151,1.120649,.0531008,-.0166008,.2648,.6684799]);return a=>{let l=Math.min(Math.max(a[0]+s,0),2);a[0]=l/(1+n-n*l),yi(r,a);for(let c=0;c<3;c++)a[c]=cm(a[c],1.7*2523/32)/i;yi(o,a),a[0]=(a[0]+(t-1)*a[2])/t,a[1]=(a[1]+(e-1)*a[0])/e}}var ZS={average:[1,.69,1],dim:[.9,.59,.9],dark:[.8,.525,.8]},KS=[.38971,.68898,-.07868,-.22981,1.1834,.04641,0,0,1];function em(i,t){let e=i.adapting_luminance??64/Math.PI/5,[n,s,r]=ZS[i.surround??"average"],o=i.reference_white_xyz.map(v=>100*v),a=1/(5*e+1),l=a**4*e+.1*(1-a**4)**2*Math.cbrt(5*e),c=(i.background??20)/o[1],h=.725*c**-.2,d=s*(1.48+Math.sqrt(c)),u=(1.64-.29**c)**.73,f=5e4/13*r*h,g=Math.min(Math.max(n*(1-Math.exp((-e-42)/92)/3.6),0),1),x=Dl[t],p=to(x,o).map(v=>g*o[1]/v+1-g),m=xu(p,x);t==="CAT02"&&(m=qs(qs(KS,Vn(x)),m));let[_,M,y]=to(m,o).map(v=>{let w=(l*Math.abs(v)/100)**.42;return Math.sign(v)*400*w/(w+27.13)+.1}),T=(2*_+M+y/20-.305)*h,E=Vn(m);return v=>{let w=Math.min(Math.max(v[0],0),200),F=Math.sqrt(w/(1.7-.007*w)/100),D=Math.sqrt(v[1]*v[1]+v[2]*v[2]),[N,O]=D>0?[v[1]/D,v[2]/D]:[1,0],V=Math.expm1(.0228*Math.min(D,500))/.0228/l**.25,C=F>0?Xs(V/(F*u),1/.9):0,H=T*Xs(F,2/d)/h,G=23*(f*.25*(N*Math.cos(2)-O*Math.sin(2)+3.8))+C*(11*N+108*O),nt=G>1e-6?23*(H+.305)*C/G:0,[$,Q]=[nt*N,nt*O];v[0]=460*H+451*$+288*Q,v[1]=460*H-891*$-261*Q,v[2]=460*H-220*$-6300*Q;for(let et=0;et<3;et++){let yt=v[et]/1403,Dt=Math.min(Math.abs(yt),399);v[et]=Math.sign(yt)*Xs(27.13*Dt/(400-Dt),1/.42)/l}yi(E,v)}}var vu=203,JS={CIELAB:({reference_white_xyz:i})=>am(i),CIELUV:({reference_white_xyz:i})=>$S(i),CIEXYZ:()=>()=>{},"CAM16-UCS":i=>em(i,"CAT16"),"CAM02-UCS":i=>em(i,"CAT02"),DIN99o:({reference_white_xyz:i})=>XS(i),Oklab:()=>qS,IPT:()=>YS,ICtCp:({luminance:i})=>tm(i??vu,!1),ITP:({luminance:i})=>tm(i??vu,!0),Jzazbz:({luminance:i})=>jS(i??vu)},QS={name:"CIELAB",axes:["L*","a*","b*"],reference_white_xyz:[...Qr],adaptation:"Bradford"};function hm(i,t){let e=Nl(),n=e.toXyz(Float32Array.from(t)),s=e.toXyz(i),r=a=>a>(6/29)**3?Math.cbrt(a):841/108*a+4/29,o=new Float32Array(i.length);for(let a=0;a<i.length;a+=3){let[l,c,h]=[0,1,2].map(d=>r(s[a+d]/n[d]));o.set([116*c-16,500*(l-c),200*(c-h)],a)}return o}function _u({options:i,provenance:t}){return{name:i.space,...t.colour_space,adaptation:i.adaptation??"Bradford"}}function sn(i){return Nl(_u(i))}var nm=1e6;function Nl(i={}){let t={...QS,...i},e=JS[t.name];if(e===void 0)throw new Error(`The page does not know the colour space ${t.name}.`);let n=e(t),s=rm(t.reference_white_xyz,Qr,Dl[t.adaptation]??Dl.Bradford),r=(o,a,l)=>{let c=new Float32Array(o.length),h=new Float64Array(3);for(let d=0;d<o.length;d+=3){for(let u=0;u<3;u++)h[u]=o[d+u];n(h);for(let u=0;u<3;u++){let f=h[u];h[u]=Number.isNaN(f)?0:Math.min(Math.max(f,-nm),nm)}yi(a,h),l(h);for(let u=0;u<3;u++)c[d+u]=h[u]}return c};return{name:t.name,axes:t.axes,lightness:t.name==="CIEXYZ"?1:0,toXyz:o=>r(o,s,()=>{}),toLab:o=>r(o,s,tM),linear:(o,a="srgb",l=!0)=>r(o,qs(WS[a],s),l?eM:()=>{})}}function tM(i){let[t,e,n]=[i[0]/Qr[0],i[1],i[2]/Qr[2]].map(s=>s>.008856451679035631?Math.cbrt(s):s*841/108+.13793103448275862);i[0]=116*e-16,i[1]=500*(t-e),i[2]=200*(e-n)}function eM(i){for(let t=0;t<3;t++)i[t]=Math.min(Math.max(i[t],0),1)}var bi=["","7 4","2 3","10 3 2 3","5 5","12 4"],nM=12,Qn=11,Wn=16,Ul=.54,yu=18,Fl=18,$n=8,iM=0;function Xn(i){let t={"&":"&amp;","<":"&lt;",">":"&gt;",'"':"&quot;","'":"&#39;"};return i.replaceAll(/[\u0000-\u0008\u000b\u000c\u000e-\u001f\ufffe\uffff]/g,"").replaceAll(/[&<>"']/g,e=>t[e])}function no(i,t){let e=i/t,n=10**Math.floor(Math.log10(e));return n*([1,2,5].find(s=>s*n>=.98*e)??10)}function je(i,t=6){return(i||0).toLocaleString("en",{maximumSignificantDigits:t,useGrouping:!1}).replace("-","−")}var Gi=class{constructor(t){this.options=t;let{size:e,title:n,caption:s="",x:r,y:o,legend:a=[],legendAt:l}=t,c=Math.max(8,Math.floor((e.width-2*$n)/(Qn*Ul)));this.titleLines=um(n,Math.floor(c*.85)),this.captionLines=um(s,c),this.top=$n+Wn*this.titleLines.length+(this.titleLines.length>0?10:0),this.legendRoom=l==="below"?yu*a.length+6:0;let h=Wn*this.captionLines.length+$n+this.legendRoom,[d,u]=t.isBare?[0,0]:[Fl+Wn+4,Wn],f=Math.max(40,e.height-this.top-h-d);this.ticks={x:[],y:bu(o,f/44)};let g=Math.max(0,...this.ticks.y.map(({text:p})=>p.length))*Qn*Ul;this.left=t.isBare?$n:$n+u+g+6;let x=Math.max(40,e.width-this.left-$n-(t.isBare?0:12));if(t.isEqual){let p=Math.min(x/(r.range[1]-r.range[0]),f/(o.range[1]-o.range[0])),m=x-p*(r.range[1]-r.range[0]);x-=m,f=p*(o.range[1]-o.range[0]),this.left+=m/2,this.ticks.y=bu(o,f/44)}this.width=x,this.height=f,this.ticks.x=bu(r,x/50)}options;left;top;width;height;id=`chart-${iM+=1}`;marks=[];definitions=[];titleLines;captionLines;legendRoom;ticks;x(t){let[e,n]=this.options.x.range;return this.left+(t-e)/(n-e)*this.width}y(t){let[e,n]=this.options.y.range;return this.top+(1-(t-e)/(n-e))*this.height}path(t,e=!0){return t.length===0?"":`M${t.map(([s,r])=>`${this.x(s).toFixed(1)},${this.y(r).toFixed(1)}`).join("L")}${e?"Z":""}`}draw(t,e){if(t==="")return;let{stroke:n="none",width:s=1.6,fill:r="none",opacity:o=1,dash:a="",rim:l=!1}=e,c=`d="${t}" stroke-linejoin="round" clip-path="url(#${this.id}-frame)"`;l&&this.marks.push(`<path ${c} fill="none" stroke="${this.options.theme.back}" stroke-width="${s+2.4}" opacity="0.75"/>`);let h=a===""?"":` stroke-dasharray="${a}"`;this.marks.push(`<path ${c} fill="${r}" stroke="${n}" stroke-width="${s}" opacity="${o}"${h}/>`)}polygon(t,e){this.draw(this.path(t),e)}line(t,e){this.draw(this.path(t,!1),e)}point([t,e],{stroke:n=this.options.theme.text,fill:s=this.options.theme.back,width:r=1.4},o=3.5){this.marks.push(`<circle cx="${this.x(t).toFixed(1)}" cy="${this.y(e).toFixed(1)}" r="${o}" fill="${s}" stroke="${n}" stroke-width="${r}"/>`)}text(t,e,n=[6,0],s="start",r=this.options.theme.text){let[o,a]=[this.x(t[0])+n[0],this.y(t[1])+n[1]+.35*Qn];this.marks.push(`<text x="${o.toFixed(1)}" y="${a.toFixed(1)}" font-size="${Qn}" text-anchor="${s}" fill="${r}"${this.rim}>${Xn(e)}</text>`)}image(t,[e,n],[s,r],o,a=1){let l=`${this.id}-clip-${this.definitions.length}`;this.definitions.push(`<clipPath id="${l}"><path clip-rule="evenodd" d="${o}"/></clipPath>`);let[c,h]=[this.x(e),this.y(r)],d=`x="${c.toFixed(2)}" y="${h.toFixed(2)}" width="${(this.x(n)-c).toFixed(2)}" height="${(this.y(s)-h).toFixed(2)}"`;this.marks.push(`<image ${d} preserveAspectRatio="none" clip-path="url(#${l})" opacity="${a}" href="${t}"/>`)}hatch(t){let e=`${this.id}-hatch-${this.definitions.length}`;return this.definitions.push(`<pattern id="${e}" width="7" height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><path d="M0,0V7" stroke="${this.options.theme.back}" stroke-width="4"/><path d="M0,0V7" stroke="${t}" stroke-width="2"/></pattern>`),`url(#${e})`}svg(){let{size:t,theme:e,title:n,x:s,y:r,isBare:o=!1}=this.options,{left:a,top:l,width:c,height:h,id:d}=this,[u,f]=[a+c,l+h],g=`x="${a.toFixed(1)}" y="${l.toFixed(1)}" width="${c.toFixed(1)}" height="${h.toFixed(1)}"`,x=(M,y,T)=>T?`<text x="${M.toFixed(1)}" y="${(f+15).toFixed(1)}" text-anchor="middle">${Xn(y)}</text>`:`<text x="${(a-6).toFixed(1)}" y="${(M+4).toFixed(1)}" text-anchor="end">${Xn(y)}</text>`,p=[...this.ticks.x.map(({value:M})=>`M${this.x(M).toFixed(1)},${l.toFixed(1)}V${f.toFixed(1)}`),...this.ticks.y.map(({value:M})=>`M${a.toFixed(1)},${this.y(M).toFixed(1)}H${u.toFixed(1)}`)].join(""),m=o?[]:[`<rect ${g} fill="none" stroke="${e.soft}" stroke-width="1"/>`,`<g font-size="${Qn}" fill="${e.soft}">`,...this.ticks.x.map(({value:M,text:y})=>x(this.x(M),y,!0)),...this.ticks.y.map(({value:M,text:y})=>x(this.y(M),y,!1)),"</g>",`<text x="${((a+u)/2).toFixed(1)}" y="${(f+Fl+Wn).toFixed(1)}" text-anchor="middle">${dm(s.label)}</text>`,`<text transform="translate(${(a-this.tickWidth-Wn+4).toFixed(1)},${((l+f)/2).toFixed(1)}) rotate(-90)" text-anchor="middle">${dm(r.label)}</text>`],_=f+(o?0:Fl+Wn+4)+Wn+this.legendRoom;return[`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${t.width} ${t.height}" width="${t.width}" height="${t.height}" role="img" font-family="system-ui, 'Segoe UI', Roboto, sans-serif" font-size="${nM}" fill="${e.text}">`,`<title>${Xn(n)}</title>`,`<defs><clipPath id="${d}-frame"><rect ${g}/></clipPath>${this.definitions.join("")}</defs>`,...e.isClear?[]:[`<rect width="100%" height="100%" fill="${e.back}"/>`],...o?[]:[`<path d="${p}" fill="none" stroke="${e.line}" stroke-width="1"/>`],...this.marks,...m,...this.legendLines(),...this.titleLines.map((M,y)=>`<text x="${$n}" y="${$n+12+Wn*y}" font-size="13" font-weight="600">${Xn(M)}</text>`),...this.captionLines.map((M,y)=>`<text x="${$n}" y="${(_+Wn*y).toFixed(1)}" font-size="${Qn}" fill="${e.soft}">${Xn(M)}</text>`),"</svg>"].join(`
`)}get tickWidth(){return Math.max(0,...this.ticks.y.map(({text:t})=>t.length))*Qn*Ul}get rim(){return` stroke="${this.options.theme.back}" stroke-width="3" stroke-linejoin="round" paint-order="stroke"`}legendLines(){let{size:t,theme:e,legend:n=[],legendAt:s="top",isBare:r}=this.options,o=s==="below",a=this.top+this.height,l={top:this.top+15,bottom:a-13-yu*(n.length-1),below:a+(r?0:Fl+Wn+4)+15}[s],c=o?t.width-2*$n:.62*this.width,h=Math.max(8,Math.floor((c-50)/(Qn*Ul)));return n.map(({name:d,style:u},f)=>{let g=l+yu*f,{stroke:x="none",width:p=1.6,dash:m=""}=u,_=o?$n:this.left+this.width-38,[M,y]=o?[_+36,"start"]:[_-6,"end"],T=m===""?"":` stroke-dasharray="${m}"`,E=`<path d="M${_.toFixed(1)},${g.toFixed(1)}h30" stroke="${x}" stroke-width="${p}"${T}/>`,v=`<text x="${M.toFixed(1)}" y="${(g+4).toFixed(1)}" font-size="${Qn}" text-anchor="${y}" fill="${e.text}"${this.rim}>${Xn(io(d,h))}</text>`;return`<g><title>${Xn(d)}</title>${E}${v}</g>`})}};function bu({range:[i,t],ticks:e},n){if(e!==void 0)return e;let s=no(t-i,Math.max(2,n)),r=Math.ceil(i/s-1e-9),o=Math.floor(t/s+1e-9)-r+1;return Array.from({length:o},(a,l)=>({value:(r+l)*s,text:je((r+l)*s)}))}function io(i,t){return i.length<=t?i:`${i.slice(0,t-1).trimEnd()}…`}function um(i,t){let e=[];for(let n of i.split(" ").filter(s=>s!=="")){let s=e.at(-1);s!==void 0&&s.length+1+n.length<=t?e[e.length-1]=`${s} ${n}`:e.push(io(n,t))}return e}function dm(i){return Xn(i).replaceAll(/_([^_]+)_/g,'<tspan font-style="italic">$1</tspan>').replaceAll(/([\^~])([^\^~]+)\1(.?)/g,(t,e,n,s)=>{let r=e==="^"?-4:4;return`<tspan dy="${r}" font-size="${Qn}">${n}</tspan>${s===""?"":`<tspan dy="${-r}">${s}</tspan>`}`})}function Ol(i,t){let e=i.length/4/t,n=new Uint8Array(e*(4*t+1));for(let h=0;h<e;h++)n.set(i.subarray(4*t*h,4*t*(h+1)),h*(4*t+1)+1);let r=[[120,1]];for(let h=0;h<n.length;h+=65535){let d=n.subarray(h,h+65535),u=d.length,f=h+u===n.length?1:0;r.push([f,u&255,u>>8,~u&255,~u>>8&255],d)}let[o,a]=[1,0];for(let h of n)o=(o+h)%65521,a=(a+o)%65521;r.push(eo((a<<16|o)>>>0));let l=[Uint8Array.of(137,80,78,71,13,10,26,10),Su("IHDR",[[...eo(t),...eo(e),8,6,0,0,0]]),Su("IDAT",r),Su("IEND",[])],c="";for(let h of l)for(let d of h)c+=String.fromCharCode(d);return`data:image/png;base64,${btoa(c)}`}function eo(i){return[i>>>24,i>>>16&255,i>>>8&255,i&255]}var sM=Uint32Array.from({length:256},(i,t)=>{for(let e=0;e<8;e++)t=t&1?3988292384^t>>>1:t>>>1;return t});function Su(i,t){let e=t.reduce((o,a)=>o+a.length,0),n=new Uint8Array(e+12);n.set([...eo(e),...Array.from(i,o=>o.charCodeAt(0))]);let s=8;for(let o of t)n.set(o,s),s+=o.length;let r=4294967295;for(let o of n.subarray(4,s))r=sM[(r^o)&255]^r>>>8;return n.set(eo(~r>>>0),s),n}var rM=[33,24],oM=24,zl='system-ui, "Segoe UI", Roboto, sans-serif',Hl=12.5,ro=9,fm=7,aM=5,so=[0,1,2];function gm(i){let t=(r,o=1)=>({name:r,sign:o,meaning:lM(r)}),[e,n,s]=i;return e==="X"?[t(e),t(n),t(s)]:[t(n),t(e),t(s,-1)]}function lM(i){return/^[XYZ]$/.test(i)?`${i} tristimulus value relative to the white, whose Y is 1`:/^(L|J|I)/.test(i)?`${i}: lightness, without a unit`:`${i}: opponent colour coordinate, without a unit; 0 on the neutral axis`}var Bl=class{constructor(t,e,n){this.axes=t;let s=e.getSize(new P);this.step=no(Math.max(s.x,s.y,s.z),12);let r=this.step/2,o=(a,l)=>r*l(a/r);this.box.min.set(...e.min.toArray().map(a=>o(a,l=>Math.floor(l+.02)))),this.box.max.set(...e.max.toArray().map(a=>o(a,l=>Math.ceil(l-.02)))),this.faint=new mn({color:n,transparent:!0,opacity:.16}),this.strong=new mn({color:n,transparent:!0,opacity:.5}),this.ticks=so.map(a=>this.ticksOf(a)),this.nameWidths=t.map(({name:a})=>pm(a,!0));for(let a of so)for(let l of[-1,1])this.addSide(a,l)}axes;group=new Ne;faint;strong;sides=[];ticks;nameWidths;step;box=new ve;dispose(){this.group.removeFromParent();for(let{lines:t}of this.sides)for(let e of[t,...t.children])e.geometry.dispose();this.faint.dispose(),this.strong.dispose()}ticksOf(t){let{sign:e}=this.axes[t],{step:n}=this,[s,r]=[this.box.min.getComponent(t),this.box.max.getComponent(t)],o=[];for(let a=Math.ceil(s/n-1e-6);a*n<=r+1e-6*n;a++){let l=je(e*a*n);o.push({text:l,at:a*n,count:a,width:pm(l,!1)})}return o}addSide(t,e){let{min:n,max:s}=this.box,r=(e<0?n:s).getComponent(t),[o,a]=so.filter(m=>m!==t),l=(m,_)=>new P().setComponent(t,r).setComponent(o,m).setComponent(a,_).toArray(),[c,h]=[n.getComponent(o),s.getComponent(o)],[d,u]=[n.getComponent(a),s.getComponent(a)],f=[...this.ticks[o].flatMap(m=>[...l(m.at,d),...l(m.at,u)]),...this.ticks[a].flatMap(m=>[...l(c,m.at),...l(h,m.at)])],g=[l(c,d),l(h,d),l(h,u),l(c,u)],x=g.flatMap((m,_)=>[...m,...g[(_+1)%4]]),p=mm(f,this.faint);p.add(mm(x,this.strong)),this.sides.push({axis:t,end:e,at:r,lines:p}),this.group.add(p)}turnTo(t){let e="isOrthographicCamera"in t,n=e?t.getWorldDirection(new P).negate():t.position;for(let{axis:s,end:r,at:o,lines:a}of this.sides)a.visible=r*(n.getComponent(s)-(e?0:o))<0}labels(t,e,n,s){let r=cM(t,e,n),o=r(this.box.getCenter(new P)),a=[],l=[],c=[];for(let h of so){let d=this.labelledEdge(h,r,o);if(d===null)continue;let{outward:u,at:f,length:g}=d,x=this.ticks[h],p=this.box.max.getComponent(h)-this.box.min.getComponent(h),m=Math.abs(u[0])>Math.abs(u[1]),_=hM(g/p*this.step,rM[m?1:0]),M=x.filter(({count:C})=>C%_===0),y=C=>Math.abs(u[0])*C*.5+Math.abs(u[1])*Hl*.5,T=(C,H)=>{let[X,G]=f(C);return[X+H*u[0],G+H*u[1]]};M.forEach(({text:C,at:H,width:X},G)=>{let[nt,$]=T(H,fm+y(X));(G===0||G===M.length-1?l:c).push({text:C,x:nt,y:$,width:X,axis:h,meaning:null})});let E=Math.max(0,...M.map(C=>C.width)),v=this.nameWidths[h],{name:w,meaning:F}=this.axes[h],D=(this.box.max.getComponent(h)+this.box.min.getComponent(h))/2,[N,O]=T(D,fm+2*y(E)+aM+y(v)),V=(C,H,X)=>Math.min(Math.max(C,H),Math.max(H,X));a.push({text:w,x:V(N,s.left+v/2+3,e-s.right-v/2-3),y:V(O,s.top+ro,n-s.bottom-ro),width:v,axis:h,meaning:F})}return uM([...a,...l,...c],e,n,s)}labelledEdge(t,e,n){let[s,r]=so.filter(f=>f!==t),o=(f,g)=>this.sides[2*f+(g<0?0:1)].lines.visible,a=null;for(let f of[-1,1])for(let g of[-1,1]){if(o(s,f)===o(r,g))continue;let x=F=>new P().setComponent(t,(F<0?this.box.min:this.box.max).getComponent(t)).setComponent(s,(f<0?this.box.min:this.box.max).getComponent(s)).setComponent(r,(g<0?this.box.min:this.box.max).getComponent(r)),[p,m]=[x(-1),x(1)],[_,M]=[e(p),e(m)],y=[M[0]-_[0],M[1]-_[1]],T=Math.hypot(...y);if(T<oM)continue;let E=[y[1]/T,-y[0]/T];(_[0]-n[0])*E[0]+(_[1]-n[1])*E[1]<0&&(E=[-E[0],-E[1]]);let w=E[1]-(t===1?2:.1)*E[0];(a===null||w>a.score)&&(a={score:w,from:p,to:m,outward:E,length:T})}if(a===null)return null;let{from:l,to:c,outward:h,length:d}=a;return{outward:h,length:d,at:f=>{let g=l.clone();return e(g.setComponent(t,Math.min(Math.max(f,l.getComponent(t)),c.getComponent(t))))}}}},vm={left:56,top:14,right:44,bottom:42};function cM(i,t,e){let n=new jt().multiplyMatrices(i.projectionMatrix,i.matrixWorldInverse),s=new P;return r=>(s.copy(r).applyMatrix4(n),[(s.x+1)*t/2,(1-s.y)*e/2])}function hM(i,t){return[1,2,5,10,20].find(e=>e*i>=t)??50}function uM(i,t,e,n){let s=[];for(let r of i){let{x:o,y:a}=r,l=r.width/2,c=o-l>=n.left+2&&o+l<=t-n.right-2&&a-ro>=n.top&&a+ro<=e-n.bottom,h=s.some(d=>Math.abs(d.x-o)<l+d.width/2+4&&Math.abs(d.y-a)<2*ro-2);c&&!h&&s.push(r)}return s}var Mu=null;function pm(i,t){return Mu??=document.createElement("canvas").getContext("2d"),Mu.font=`${t?600:400} ${Hl}px ${zl}`,Mu.measureText(i).width}function mm(i,t){let e=new he;return e.setAttribute("position",new Qt(i,3)),new Rn(e,t)}var wu="http://www.w3.org/2000/svg",kl=class{element=document.createElementNS(wu,"svg");nodes=new Map;constructor(){this.element.setAttribute("class","labels"),this.element.setAttribute("aria-hidden","true")}clear(){this.element.replaceChildren(),this.nodes.clear()}show(t){let e=new Set(this.nodes.values());for(let{text:n,x:s,y:r,axis:o,meaning:a}of t){let l=`${o} ${n}`,c=this.nodes.get(l)??this.add(l,n,a);c.setAttribute("transform",`translate(${s.toFixed(1)} ${r.toFixed(1)})`),c.removeAttribute("display"),e.delete(c)}for(let n of e)n.setAttribute("display","none")}add(t,e,n){let s=document.createElementNS(wu,"text");if(s.setAttribute("dy",".35em"),s.textContent=e,n!==null){s.setAttribute("class","name");let r=document.createElementNS(wu,"title");r.textContent=n,s.append(r)}return this.nodes.set(t,s),this.element.append(s),s}};function xm(i,t){let{positions:e}=i,n=e.length/3,s=[0,0,0];for(let l=0;l<e.length;l++)s[l%3]+=e[l]/n;let r=Math.max(1,n/64),[o,a]=[0,0];for(let l=0;l<n;l+=r){let c=3*Math.floor(l),[h,d,u]=s.map((f,g)=>f*.03+e[c+g]*(1-.03));a+=1,dM(t,h,d,u)&&(o+=1)}return o>=.95*a}function dM({positions:i,faces:t},e,n,s){let r=!1;for(let o=0;o<t.length;o+=3){let[a,l,c]=[3*t[o],3*t[o+1],3*t[o+2]],[h,d]=[i[a+1]-n,i[a+2]-s],[u,f]=[i[l+1]-n,i[l+2]-s],[g,x]=[i[c+1]-n,i[c+2]-s],[p,m,_]=[u*x-f*g,g*d-x*h,h*f-d*u];if(!(p>=0&&m>=0&&_>=0||p<=0&&m<=0&&_<=0))continue;let M=p+m+_;M!==0&&(p*i[a]+m*i[l]+_*i[c])/M>e&&(r=!r)}return r}var _m={type:"change"},Au={type:"start"},bm={type:"end"},Gl=new pi,ym=new Xe,fM=Math.cos(70*_i.DEG2RAD),Re=new P,cn=2*Math.PI,Kt={NONE:-1,ROTATE:0,DOLLY:1,PAN:2,TOUCH_ROTATE:3,TOUCH_PAN:4,TOUCH_DOLLY_PAN:5,TOUCH_DOLLY_ROTATE:6},Eu=1e-6,Vl=class extends Br{constructor(t,e=null){super(t,e),this.state=Kt.NONE,this.target=new P,this.cursor=new P,this.minDistance=0,this.maxDistance=1/0,this.minZoom=0,this.maxZoom=1/0,this.minTargetRadius=0,this.maxTargetRadius=1/0,this.minPolarAngle=0,this.maxPolarAngle=Math.PI,this.minAzimuthAngle=-1/0,this.maxAzimuthAngle=1/0,this.enableDamping=!1,this.dampingFactor=.05,this.enableZoom=!0,this.zoomSpeed=1,this.enableRotate=!0,this.rotateSpeed=1,this.keyRotateSpeed=1,this.enablePan=!0,this.panSpeed=1,this.screenSpacePanning=!0,this.keyPanSpeed=7,this.zoomToCursor=!1,this.autoRotate=!1,this.autoRotateSpeed=2,this.keys={LEFT:"ArrowLeft",UP:"ArrowUp",RIGHT:"ArrowRight",BOTTOM:"ArrowDown"},this.mouseButtons={LEFT:Bi.ROTATE,MIDDLE:Bi.DOLLY,RIGHT:Bi.PAN},this.touches={ONE:ki.ROTATE,TWO:ki.DOLLY_PAN},this.target0=this.target.clone(),this.position0=this.object.position.clone(),this.zoom0=this.object.zoom,this._cursorStyle="auto",this._domElementKeyEvents=null,this._lastPosition=new P,this._lastQuaternion=new fn,this._lastTargetPosition=new P,this._quat=new fn().setFromUnitVectors(t.up,new P(0,1,0)),this._quatInverse=this._quat.clone().invert(),this._spherical=new kn,this._sphericalDelta=new kn,this._scale=1,this._panOffset=new P,this._rotateStart=new Ct,this._rotateEnd=new Ct,this._rotateDelta=new Ct,this._panStart=new Ct,this._panEnd=new Ct,this._panDelta=new Ct,this._dollyStart=new Ct,this._dollyEnd=new Ct,this._dollyDelta=new Ct,this._dollyDirection=new P,this._mouse=new Ct,this._performCursorZoom=!1,this._pointers=[],this._pointerPositions={},this._controlActive=!1,this._onPointerMove=mM.bind(this),this._onPointerDown=pM.bind(this),this._onPointerUp=gM.bind(this),this._onContextMenu=MM.bind(this),this._onMouseWheel=_M.bind(this),this._onKeyDown=yM.bind(this),this._onTouchStart=bM.bind(this),this._onTouchMove=SM.bind(this),this._onMouseDown=vM.bind(this),this._onMouseMove=xM.bind(this),this._interceptControlDown=wM.bind(this),this._interceptControlUp=EM.bind(this),this.domElement!==null&&this.connect(this.domElement),this.update()}set cursorStyle(t){this._cursorStyle=t,t==="grab"?this.domElement.style.cursor="grab":this.domElement.style.cursor="auto"}get cursorStyle(){return this._cursorStyle}connect(t){super.connect(t),this.domElement.addEventListener("pointerdown",this._onPointerDown),this.domElement.addEventListener("pointercancel",this._onPointerUp),this.domElement.addEventListener("contextmenu",this._onContextMenu),this.domElement.addEventListener("wheel",this._onMouseWheel,{passive:!1}),this.domElement.ownerDocument.addEventListener("keydown",this._interceptControlDown,{passive:!0,capture:!0}),this.domElement.style.touchAction="none"}disconnect(){this.state=Kt.NONE,this.domElement.removeEventListener("pointerdown",this._onPointerDown),this.domElement.ownerDocument.removeEventListener("pointermove",this._onPointerMove),this.domElement.ownerDocument.removeEventListener("pointerup",this._onPointerUp),this.domElement.removeEventListener("pointercancel",this._onPointerUp),this.domElement.removeEventListener("wheel",this._onMouseWheel),this.domElement.removeEventListener("contextmenu",this._onContextMenu),this.stopListenToKeyEvents(),this.domElement.ownerDocument.removeEventListener("keydown",this._interceptControlDown,{capture:!0}),this.domElement.ownerDocument.removeEventListener("keyup",this._interceptControlUp,{capture:!0}),this._controlActive=!1,this._pointers.length=0,this._pointerPositions={},this.domElement.style.touchAction="",this.domElement.style.cursor="auto"}dispose(){this.disconnect()}getPolarAngle(){return this._spherical.phi}getAzimuthalAngle(){return this._spherical.theta}getDistance(){return this.object.position.distanceTo(this.target)}listenToKeyEvents(t){t.addEventListener("keydown",this._onKeyDown),this._domElementKeyEvents=t}stopListenToKeyEvents(){this._domElementKeyEvents!==null&&(this._domElementKeyEvents.removeEventListener("keydown",this._onKeyDown),this._domElementKeyEvents=null)}saveState(){this.target0.copy(this.target),this.position0.copy(this.object.position),this.zoom0=this.object.zoom}reset(){this.target.copy(this.target0),this.object.position.copy(this.position0),this.object.zoom=this.zoom0,this.object.updateProjectionMatrix(),this.dispatchEvent(_m),this.update(),this.state=Kt.NONE}pan(t,e){this._pan(t,e),this.update()}dollyIn(t){this._dollyIn(t),this.update()}dollyOut(t){this._dollyOut(t),this.update()}rotateLeft(t){this._rotateLeft(t),this.update()}rotateUp(t){this._rotateUp(t),this.update()}update(t=null){let e=this.object.position;Re.copy(e).sub(this.target),Re.applyQuaternion(this._quat),this._spherical.setFromVector3(Re),this.autoRotate&&this.state===Kt.NONE&&this._rotateLeft(this._getAutoRotationAngle(t)),this.enableDamping?(this._spherical.theta+=this._sphericalDelta.theta*this.dampingFactor,this._spherical.phi+=this._sphericalDelta.phi*this.dampingFactor):(this._spherical.theta+=this._sphericalDelta.theta,this._spherical.phi+=this._sphericalDelta.phi);let n=this.minAzimuthAngle,s=this.maxAzimuthAngle;isFinite(n)&&isFinite(s)&&(n<-Math.PI?n+=cn:n>Math.PI&&(n-=cn),s<-Math.PI?s+=cn:s>Math.PI&&(s-=cn),n<=s?this._spherical.theta=Math.max(n,Math.min(s,this._spherical.theta)):this._spherical.theta=this._spherical.theta>(n+s)/2?Math.max(n,this._spherical.theta):Math.min(s,this._spherical.theta)),this._spherical.phi=Math.max(this.minPolarAngle,Math.min(this.maxPolarAngle,this._spherical.phi)),this._spherical.makeSafe(),this.enableDamping===!0?this.target.addScaledVector(this._panOffset,this.dampingFactor):this.target.add(this._panOffset),this.target.sub(this.cursor),this.target.clampLength(this.minTargetRadius,this.maxTargetRadius),this.target.add(this.cursor);let r=!1;if(this.zoomToCursor&&this._performCursorZoom||this.object.isOrthographicCamera)this._spherical.radius=this._clampDistance(this._spherical.radius);else{let o=this._spherical.radius;this._spherical.radius=this._clampDistance(this._spherical.radius*this._scale),r=o!=this._spherical.radius}if(Re.setFromSpherical(this._spherical),Re.applyQuaternion(this._quatInverse),e.copy(this.target).add(Re),this.object.lookAt(this.target),this.enableDamping===!0?(this._sphericalDelta.theta*=1-this.dampingFactor,this._sphericalDelta.phi*=1-this.dampingFactor,this._panOffset.multiplyScalar(1-this.dampingFactor)):(this._sphericalDelta.set(0,0,0),this._panOffset.set(0,0,0)),this.zoomToCursor&&this._performCursorZoom){let o=null;if(this.object.isPerspectiveCamera){let a=Re.length();o=this._clampDistance(a*this._scale);let l=a-o;this.object.position.addScaledVector(this._dollyDirection,l),this.object.updateMatrixWorld(),r=!!l}else if(this.object.isOrthographicCamera){let a=new P(this._mouse.x,this._mouse.y,0);a.unproject(this.object);let l=this.object.zoom;this.object.zoom=Math.max(this.minZoom,Math.min(this.maxZoom,this.object.zoom/this._scale)),this.object.updateProjectionMatrix(),r=l!==this.object.zoom;let c=new P(this._mouse.x,this._mouse.y,0);c.unproject(this.object),this.object.position.sub(c).add(a),this.object.updateMatrixWorld(),o=Re.length()}else console.warn("WARNING: OrbitControls.js encountered an unknown camera type - zoom to cursor disabled."),this.zoomToCursor=!1;o!==null&&(this.screenSpacePanning?this.target.set(0,0,-1).transformDirection(this.object.matrix).multiplyScalar(o).add(this.object.position):(Gl.origin.copy(this.object.position),Gl.direction.set(0,0,-1).transformDirection(this.object.matrix),Math.abs(this.object.up.dot(Gl.direction))<fM?this.object.lookAt(this.target):(ym.setFromNormalAndCoplanarPoint(this.object.up,this.target),Gl.intersectPlane(ym,this.target))))}else if(this.object.isOrthographicCamera){let o=this.object.zoom;this.object.zoom=Math.max(this.minZoom,Math.min(this.maxZoom,this.object.zoom/this._scale)),o!==this.object.zoom&&(this.object.updateProjectionMatrix(),r=!0)}return this._scale=1,this._performCursorZoom=!1,r||this._lastPosition.distanceToSquared(this.object.position)>Eu||8*(1-this._lastQuaternion.dot(this.object.quaternion))>Eu||this._lastTargetPosition.distanceToSquared(this.target)>Eu?(this.dispatchEvent(_m),this._lastPosition.copy(this.object.position),this._lastQuaternion.copy(this.object.quaternion),this._lastTargetPosition.copy(this.target),!0):!1}_getAutoRotationAngle(t){return t!==null?cn/60*this.autoRotateSpeed*t:cn/60/60*this.autoRotateSpeed}_getZoomScale(t){let e=Math.abs(t*.01);return Math.pow(.95,this.zoomSpeed*e)}_rotateLeft(t){this._sphericalDelta.theta-=t}_rotateUp(t){this._sphericalDelta.phi-=t}_panLeft(t,e){Re.setFromMatrixColumn(e,0),Re.multiplyScalar(-t),this._panOffset.add(Re)}_panUp(t,e){this.screenSpacePanning===!0?Re.setFromMatrixColumn(e,1):(Re.setFromMatrixColumn(e,0),Re.crossVectors(this.object.up,Re)),Re.multiplyScalar(t),this._panOffset.add(Re)}_pan(t,e){let n=this.domElement;if(this.object.isPerspectiveCamera){let s=this.object.position;Re.copy(s).sub(this.target);let r=Re.length();r*=Math.tan(this.object.fov/2*Math.PI/180),this._panLeft(2*t*r/n.clientHeight,this.object.matrix),this._panUp(2*e*r/n.clientHeight,this.object.matrix)}else this.object.isOrthographicCamera?(this._panLeft(t*(this.object.right-this.object.left)/this.object.zoom/n.clientWidth,this.object.matrix),this._panUp(e*(this.object.top-this.object.bottom)/this.object.zoom/n.clientHeight,this.object.matrix)):(console.warn("WARNING: OrbitControls.js encountered an unknown camera type - pan disabled."),this.enablePan=!1)}_dollyOut(t){this.object.isPerspectiveCamera||this.object.isOrthographicCamera?this._scale/=t:(console.warn("WARNING: OrbitControls.js encountered an unknown camera type - dolly/zoom disabled."),this.enableZoom=!1)}_dollyIn(t){this.object.isPerspectiveCamera||this.object.isOrthographicCamera?this._scale*=t:(console.warn("WARNING: OrbitControls.js encountered an unknown camera type - dolly/zoom disabled."),this.enableZoom=!1)}_updateZoomParameters(t,e){if(!this.zoomToCursor)return;this._performCursorZoom=!0;let n=this.domElement.getBoundingClientRect(),s=t-n.left,r=e-n.top,o=n.width,a=n.height;this._mouse.x=s/o*2-1,this._mouse.y=-(r/a)*2+1,this._dollyDirection.set(this._mouse.x,this._mouse.y,1).unproject(this.object).sub(this.object.position).normalize()}_clampDistance(t){return Math.max(this.minDistance,Math.min(this.maxDistance,t))}_handleMouseDownRotate(t){this._rotateStart.set(t.clientX,t.clientY)}_handleMouseDownDolly(t){this._updateZoomParameters(t.clientX,t.clientY),this._dollyStart.set(t.clientX,t.clientY)}_handleMouseDownPan(t){this._panStart.set(t.clientX,t.clientY)}_handleMouseMoveRotate(t){this._rotateEnd.set(t.clientX,t.clientY),this._rotateDelta.subVectors(this._rotateEnd,this._rotateStart).multiplyScalar(this.rotateSpeed);let e=this.domElement;this._rotateLeft(cn*this._rotateDelta.x/e.clientHeight),this._rotateUp(cn*this._rotateDelta.y/e.clientHeight),this._rotateStart.copy(this._rotateEnd),this.update()}_handleMouseMoveDolly(t){this._dollyEnd.set(t.clientX,t.clientY),this._dollyDelta.subVectors(this._dollyEnd,this._dollyStart),this._dollyDelta.y>0?this._dollyOut(this._getZoomScale(this._dollyDelta.y)):this._dollyDelta.y<0&&this._dollyIn(this._getZoomScale(this._dollyDelta.y)),this._dollyStart.copy(this._dollyEnd),this.zoomToCursor&&(this._performCursorZoom=!0,this._dollyDirection.set(this._mouse.x,this._mouse.y,1).unproject(this.object).sub(this.object.position).normalize()),this.update()}_handleMouseMovePan(t){this._panEnd.set(t.clientX,t.clientY),this._panDelta.subVectors(this._panEnd,this._panStart).multiplyScalar(this.panSpeed),this._pan(this._panDelta.x,this._panDelta.y),this._panStart.copy(this._panEnd),this.update()}_handleMouseWheel(t){this._updateZoomParameters(t.clientX,t.clientY),t.deltaY<0?this._dollyIn(this._getZoomScale(t.deltaY)):t.deltaY>0&&this._dollyOut(this._getZoomScale(t.deltaY)),this.update()}_handleKeyDown(t){let e=!1;switch(t.code){case this.keys.UP:t.ctrlKey||t.metaKey||t.shiftKey?this.enableRotate&&this._rotateUp(cn*this.keyRotateSpeed/this.domElement.clientHeight):this.enablePan&&this._pan(0,this.keyPanSpeed),e=!0;break;case this.keys.BOTTOM:t.ctrlKey||t.metaKey||t.shiftKey?this.enableRotate&&this._rotateUp(-cn*this.keyRotateSpeed/this.domElement.clientHeight):this.enablePan&&this._pan(0,-this.keyPanSpeed),e=!0;break;case this.keys.LEFT:t.ctrlKey||t.metaKey||t.shiftKey?this.enableRotate&&this._rotateLeft(cn*this.keyRotateSpeed/this.domElement.clientHeight):this.enablePan&&this._pan(this.keyPanSpeed,0),e=!0;break;case this.keys.RIGHT:t.ctrlKey||t.metaKey||t.shiftKey?this.enableRotate&&this._rotateLeft(-cn*this.keyRotateSpeed/this.domElement.clientHeight):this.enablePan&&this._pan(-this.keyPanSpeed,0),e=!0;break}e&&(t.preventDefault(),this.update())}_handleTouchStartRotate(t){if(this._pointers.length===1)this._rotateStart.set(t.pageX,t.pageY);else{let e=this._getSecondPointerPosition(t),n=.5*(t.pageX+e.x),s=.5*(t.pageY+e.y);this._rotateStart.set(n,s)}}_handleTouchStartPan(t){if(this._pointers.length===1)this._panStart.set(t.pageX,t.pageY);else{let e=this._getSecondPointerPosition(t),n=.5*(t.pageX+e.x),s=.5*(t.pageY+e.y);this._panStart.set(n,s)}}_handleTouchStartDolly(t){let e=this._getSecondPointerPosition(t),n=t.pageX-e.x,s=t.pageY-e.y,r=Math.sqrt(n*n+s*s);this._dollyStart.set(0,r)}_handleTouchStartDollyPan(t){this.enableZoom&&this._handleTouchStartDolly(t),this.enablePan&&this._handleTouchStartPan(t)}_handleTouchStartDollyRotate(t){this.enableZoom&&this._handleTouchStartDolly(t),this.enableRotate&&this._handleTouchStartRotate(t)}_handleTouchMoveRotate(t){if(this._pointers.length==1)this._rotateEnd.set(t.pageX,t.pageY);else{let n=this._getSecondPointerPosition(t),s=.5*(t.pageX+n.x),r=.5*(t.pageY+n.y);this._rotateEnd.set(s,r)}this._rotateDelta.subVectors(this._rotateEnd,this._rotateStart).multiplyScalar(this.rotateSpeed);let e=this.domElement;this._rotateLeft(cn*this._rotateDelta.x/e.clientHeight),this._rotateUp(cn*this._rotateDelta.y/e.clientHeight),this._rotateStart.copy(this._rotateEnd)}_handleTouchMovePan(t){if(this._pointers.length===1)this._panEnd.set(t.pageX,t.pageY);else{let e=this._getSecondPointerPosition(t),n=.5*(t.pageX+e.x),s=.5*(t.pageY+e.y);this._panEnd.set(n,s)}this._panDelta.subVectors(this._panEnd,this._panStart).multiplyScalar(this.panSpeed),this._pan(this._panDelta.x,this._panDelta.y),this._panStart.copy(this._panEnd)}_handleTouchMoveDolly(t){let e=this._getSecondPointerPosition(t),n=t.pageX-e.x,s=t.pageY-e.y,r=Math.sqrt(n*n+s*s);this._dollyEnd.set(0,r),this._dollyDelta.set(0,Math.pow(this._dollyEnd.y/this._dollyStart.y,this.zoomSpeed)),this._dollyOut(this._dollyDelta.y),this._dollyStart.copy(this._dollyEnd);let o=(t.pageX+e.x)*.5,a=(t.pageY+e.y)*.5;this._updateZoomParameters(o,a)}_handleTouchMoveDollyPan(t){this.enableZoom&&this._handleTouchMoveDolly(t),this.enablePan&&this._handleTouchMovePan(t)}_handleTouchMoveDollyRotate(t){this.enableZoom&&this._handleTouchMoveDolly(t),this.enableRotate&&this._handleTouchMoveRotate(t)}_addPointer(t){this._pointers.push(t.pointerId)}_removePointer(t){delete this._pointerPositions[t.pointerId];for(let e=0;e<this._pointers.length;e++)if(this._pointers[e]==t.pointerId){this._pointers.splice(e,1);return}}_isTrackingPointer(t){for(let e=0;e<this._pointers.length;e++)if(this._pointers[e]==t.pointerId)return!0;return!1}_trackPointer(t){let e=this._pointerPositions[t.pointerId];e===void 0&&(e=new Ct,this._pointerPositions[t.pointerId]=e),e.set(t.pageX,t.pageY)}_getSecondPointerPosition(t){let e=t.pointerId===this._pointers[0]?this._pointers[1]:this._pointers[0];return this._pointerPositions[e]}_customWheelEvent(t){let e=t.deltaMode,n={clientX:t.clientX,clientY:t.clientY,deltaY:t.deltaY};switch(e){case 1:n.deltaY*=16;break;case 2:n.deltaY*=100;break}return t.ctrlKey&&!this._controlActive&&(n.deltaY*=10),n}};function pM(i){this.enabled!==!1&&(this._pointers.length===0&&(this.domElement.setPointerCapture(i.pointerId),this.domElement.ownerDocument.addEventListener("pointermove",this._onPointerMove),this.domElement.ownerDocument.addEventListener("pointerup",this._onPointerUp)),!this._isTrackingPointer(i)&&(this._addPointer(i),i.pointerType==="touch"?this._onTouchStart(i):this._onMouseDown(i),this._cursorStyle==="grab"&&(this.domElement.style.cursor="grabbing")))}function mM(i){this.enabled!==!1&&(i.pointerType==="touch"?this._onTouchMove(i):this._onMouseMove(i))}function gM(i){switch(this._removePointer(i),this._pointers.length){case 0:this.domElement.releasePointerCapture(i.pointerId),this.domElement.ownerDocument.removeEventListener("pointermove",this._onPointerMove),this.domElement.ownerDocument.removeEventListener("pointerup",this._onPointerUp),this.dispatchEvent(bm),this.state=Kt.NONE,this._cursorStyle==="grab"&&(this.domElement.style.cursor="grab");break;case 1:let t=this._pointers[0],e=this._pointerPositions[t];this._onTouchStart({pointerId:t,pageX:e.x,pageY:e.y});break}}function vM(i){let t;switch(i.button){case 0:t=this.mouseButtons.LEFT;break;case 1:t=this.mouseButtons.MIDDLE;break;case 2:t=this.mouseButtons.RIGHT;break;default:t=-1}switch(t){case Bi.DOLLY:if(this.enableZoom===!1)return;this._handleMouseDownDolly(i),this.state=Kt.DOLLY;break;case Bi.ROTATE:if(i.ctrlKey||i.metaKey||i.shiftKey){if(this.enablePan===!1)return;this._handleMouseDownPan(i),this.state=Kt.PAN}else{if(this.enableRotate===!1)return;this._handleMouseDownRotate(i),this.state=Kt.ROTATE}break;case Bi.PAN:if(i.ctrlKey||i.metaKey||i.shiftKey){if(this.enableRotate===!1)return;this._handleMouseDownRotate(i),this.state=Kt.ROTATE}else{if(this.enablePan===!1)return;this._handleMouseDownPan(i),this.state=Kt.PAN}break;default:this.state=Kt.NONE}this.state!==Kt.NONE&&this.dispatchEvent(Au)}function xM(i){switch(this.state){case Kt.ROTATE:if(this.enableRotate===!1)return;this._handleMouseMoveRotate(i);break;case Kt.DOLLY:if(this.enableZoom===!1)return;this._handleMouseMoveDolly(i);break;case Kt.PAN:if(this.enablePan===!1)return;this._handleMouseMovePan(i);break}}function _M(i){this.enabled===!1||this.enableZoom===!1||this.state!==Kt.NONE||(i.preventDefault(),this.dispatchEvent(Au),this._handleMouseWheel(this._customWheelEvent(i)),this.dispatchEvent(bm))}function yM(i){this.enabled!==!1&&this._handleKeyDown(i)}function bM(i){switch(this._trackPointer(i),this._pointers.length){case 1:switch(this.touches.ONE){case ki.ROTATE:if(this.enableRotate===!1){this.state=Kt.NONE;break}this._handleTouchStartRotate(i),this.state=Kt.TOUCH_ROTATE;break;case ki.PAN:if(this.enablePan===!1){this.state=Kt.NONE;break}this._handleTouchStartPan(i),this.state=Kt.TOUCH_PAN;break;default:this.state=Kt.NONE}break;case 2:switch(this.touches.TWO){case ki.DOLLY_PAN:if(this.enableZoom===!1&&this.enablePan===!1)return;this._handleTouchStartDollyPan(i),this.state=Kt.TOUCH_DOLLY_PAN;break;case ki.DOLLY_ROTATE:if(this.enableZoom===!1&&this.enableRotate===!1)return;this._handleTouchStartDollyRotate(i),this.state=Kt.TOUCH_DOLLY_ROTATE;break;default:this.state=Kt.NONE}break;default:this.state=Kt.NONE}this.state!==Kt.NONE&&this.dispatchEvent(Au)}function SM(i){switch(this._trackPointer(i),this.state){case Kt.TOUCH_ROTATE:if(this.enableRotate===!1)return;this._handleTouchMoveRotate(i),this.update();break;case Kt.TOUCH_PAN:if(this.enablePan===!1)return;this._handleTouchMovePan(i),this.update();break;case Kt.TOUCH_DOLLY_PAN:if(this.enableZoom===!1&&this.enablePan===!1)return;this._handleTouchMoveDollyPan(i),this.update();break;case Kt.TOUCH_DOLLY_ROTATE:if(this.enableZoom===!1&&this.enableRotate===!1)return;this._handleTouchMoveDollyRotate(i),this.update();break;default:this.state=Kt.NONE}}function MM(i){this.enabled!==!1&&i.preventDefault()}function wM(i){i.key==="Control"&&(this._controlActive=!0,this.domElement.ownerDocument.addEventListener("keyup",this._interceptControlUp,{passive:!0,capture:!0}))}function EM(i){i.key==="Control"&&(this._controlActive=!1,this.domElement.ownerDocument.removeEventListener("keyup",this._interceptControlUp,{passive:!0,capture:!0}))}var Cm=30,oo=Math.tan(Cm*Math.PI/360),AM=20,TM=2,CM=.35,Sm=250,Tu=new P(.55,.42,1),RM=16,Mm=.3,wm=1/4,PM=12,Em=4,IM=.6,LM=1.02,DM=280,NM=2*Math.PI/4e4,Am=24,Rm={left:0,top:0,right:0,bottom:0},Tm=matchMedia("(prefers-reduced-motion: reduce)"),Wl=class{constructor(t,e){this.canvas=t;this.stage=e;this.renderer=new Sl({canvas:t,alpha:!0,antialias:!0,stencil:!0});let n=this.renderer.getContext();"drawingBufferColorSpace"in n&&(n.drawingBufferColorSpace=ge),this.renderer.debug.checkShaderErrors=!1,t.after(this.labels.element),this.controls=new Vl(this.perspective,t),this.controls.zoomToCursor=!0,this.controls.addEventListener("start",()=>this.touched()),this.controls.addEventListener("change",()=>{this.limit(),this.centre(),this.spinning||this.onMove(),this.draw()});let s=new ResizeObserver(()=>this.resize());for(let r of[e,...e.querySelectorAll("[data-edge]")])s.observe(r);this.resize(),this.home()}canvas;stage;scene=new br;renderer;perspective=new tn(Cm);orthographic=new Bs;controls;raycaster=new Fr;labels=new kl;box=new ve(new P().setScalar(-60),new P().setScalar(60));middle=new P;radius=100;axes=null;width=1;height=1;covered=Rm;fitted=Tu;turning=null;spinning=!1;waiting=0;resolution=1;drawnAt=0;slow=0;resting=0;frames=0;kept=null;onDraw=[];onMove=()=>{};get projection(){return this.camera===this.perspective?"perspective":"orthographic"}get camera(){return this.controls.object}get isHome(){return this.fitted===Tu}setProjection(t){if(t===this.projection)return;let{target:e}=this.controls,{position:n,up:s}=this.camera,r=this.visibleSize(),o=t==="perspective"?this.perspective:this.orthographic;if(o.up.copy(s),o.position.copy(n),this.controls.object=o,o===this.perspective){let a=n.clone().sub(e).setLength(r/oo);o.position.copy(e).add(a)}else o.zoom=this.radius/r;this.resize(),this.controls.update(),this.onMove()}setExtent(t,e){let{scale:n}=this,s=t??this.box.clone();this.axes?.dispose(),this.axes=e,this.labels.clear(),e!==null&&this.scene.add(e.group);let r=s.getSize(new P).length()/2;this.box.copy(s),(e?.box??s).getCenter(this.middle),this.controls.cursor.copy(this.middle),this.controls.maxTargetRadius=IM*r,this.fitted===null&&(this.camera.position.sub(this.controls.target).add(this.middle),this.controls.target.copy(this.middle)),this.radius=r,this.refit(n),this.controls.update()}home(){this.lookAlong(Tu)}lookAlong(t){this.touched(),this.fitted=t,this.moveTo(this.fittedPlace(t))}spin(t){this.spinning=t&&!Tm.matches,this.spinning&&this.fitted!==null&&this.moveTo(this.fittedPlace(this.fitted)),this.draw()}turn(t,e){this.touched(),this.turnBy(t,e)}enlarge(t){this.touched();let{controls:e,orthographic:n}=this;this.camera===n?(n.zoom=_i.clamp(n.zoom*t,e.minZoom,e.maxZoom),n.updateProjectionMatrix()):this.camera.position.sub(e.target).divideScalar(t).add(e.target),e.update(),this.onMove(),this.draw()}get place(){let{camera:t,scale:e}=this,n=t===this.orthographic,s=this.controls.target.clone().sub(this.middle).divideScalar(this.radius);return[...this.towardsCamera.multiplyScalar(Em/(n?1:e)).add(s).toArray(),...s.toArray(),n?e:1].map(a=>Number(a.toPrecision(4)))}restore(t){if(t.length!==7||!t.every(Number.isFinite)||t[6]<=0)return;let[e,n]=[new P().fromArray(t,3),new P().fromArray(t)];n.sub(e),n.length()!==0&&(this.touched(),this.controls.target.copy(e).multiplyScalar(this.radius).add(this.middle),this.camera.position.copy(this.controls.target).add(n),this.refit(this.camera===this.orthographic?t[6]:Em/n.length()),this.controls.update(),this.draw())}draw(){this.waiting===0&&(this.waiting=requestAnimationFrame(t=>{this.waiting=0,this.move(t),this.adapt(t-this.drawnAt),this.drawnAt=t,this.drawNow(),(this.turning!==null||this.spinning)&&this.draw()}))}pick(t,e,n){let s=this.canvas.getBoundingClientRect(),r=new Ct(2*(t-s.left)/s.width-1,1-2*(e-s.top)/s.height);this.raycaster.setFromCamera(r,this.camera);let o=({point:a})=>(this.kept?.distanceToPoint(a)??0)>-1e-4*this.radius;return this.raycaster.intersectObjects(n,!1).find(o)??null}stagePlace(t){this.camera.updateMatrixWorld();let{x:e,y:n}=t.project(this.camera);return[(e+1)/2*this.stage.clientWidth,(1-n)/2*this.stage.clientHeight]}get towardsCamera(){return this.camera.position.clone().sub(this.controls.target).normalize()}at({width:t,height:e,ratio:n,isClear:s},r,o){let{camera:a,canvas:l,controls:c,renderer:h}=this,d=a.clone(),u={width:this.width,height:this.height,covered:this.covered},{scale:f}=this;Object.assign(this,{width:t,height:e,covered:r});try{h.setDrawingBufferSize(t,e,n);let g=h.getContext();if(g.drawingBufferWidth<Math.floor(t*n)||g.drawingBufferHeight<Math.floor(e*n))throw new Error("This browser cannot draw so large a picture. Choose a smaller one.");let x=this.fittedPlace(this.fitted??this.towardsCamera,!1),p=this.fitted===null?c.target:x.target;return a===this.orthographic?a.zoom=f*x.zoom:x.offset.radius/=f,a.position.setFromSpherical(x.offset).add(p),a.lookAt(p),this.setFrame(),this.render(s),o(l,this.axes?.labels(a,t,e,r)??[])}finally{a.position.copy(d.position),a.quaternion.copy(d.quaternion),a.zoom=d.zoom,Object.assign(this,u),this.resize(),this.drawNow()}}picture(){return this.setResolution(1),this.drawNow(),new Promise((t,e)=>this.canvas.toBlob(n=>n===null?e(new Error("no picture")):t(n)))}drawNow(){this.render(),this.labels.show(this.axes?.labels(this.camera,this.width,this.height,this.covered)??[]),this.frames+=1;for(let t of this.onDraw)t()}render(t=!1){let{axes:e,camera:n,scene:s}=this;s.background=t?null:new Gt(getComputedStyle(this.stage).backgroundColor),e?.turnTo(n),this.renderer.render(s,n)}touched(){this.turning=null,this.fitted=null,this.spinning&&(this.spinning=!1,this.onMove())}move(t){let{turning:e}=this;if(e!==null){e.since||=t;let n=Math.min(1,(t-e.since)/DM);n===1&&(this.turning=null),this.setPlace(FM(e.from,e.to,n*n*(3-2*n)))}else this.spinning&&this.turnBy(-NM*Math.min(100,t-this.drawnAt),0)}turnBy(t,e){let{target:n}=this.controls,s=new kn().setFromVector3(this.camera.position.clone().sub(n));s.theta+=t,s.phi=Math.min(Math.max(s.phi+e,1e-4),Math.PI-1e-4),this.camera.position.setFromSpherical(s).add(n),this.controls.update()}moveTo(t){this.turning=null,Tm.matches||this.frames===0?this.setPlace(t):this.turning={from:this.currentPlace(),to:t,since:0},this.draw()}currentPlace(){let{target:t}=this.controls,e=new kn().setFromVector3(this.camera.position.clone().sub(t));return{target:t.clone(),offset:e,zoom:this.orthographic.zoom}}setPlace({target:t,offset:e,zoom:n}){this.controls.target.copy(t),this.camera.position.setFromSpherical(e).add(t),this.orthographic.zoom=n,this.orthographic.updateProjectionMatrix(),this.limit(),this.controls.update(),this.onMove()}fittedPlace(t,e=this.spinning){let{middle:n}=this,[s,r]=this.freePart(),o=this.shiftFor(t),[a,l]=[0,0];for(let[c,h,d]of this.corners(t,e?Am:1)){let u=Math.max(Math.abs(c)/s,Math.abs(h)/r),f=Math.max(Math.abs(c)/s,h>0?h/(r+o):-h/(r-o));a=Math.max(a,f/oo+d),l=Math.max(l,u)}return{target:n.clone(),offset:new kn().setFromVector3(t.clone().setLength(a)),zoom:this.radius/l}}freePart(){let{height:t,width:e}=this,{left:n,top:s,right:r,bottom:o}=this.margins();return[Math.max(Mm*e,e-n-r)/t,Math.max(Mm*t,t-s-o)/t]}margins(){let{axes:t,covered:e}=this,n=s=>e[s]+(t===null?RM:vm[s]);return{left:n("left"),top:n("top"),right:n("right"),bottom:n("bottom")}}corners(t,e){let{min:n,max:s}=this.axes?.box??this.box,r=new P(0,1,0);return Array.from({length:8*e},(o,a)=>{let l=t.clone().normalize().applyAxisAngle(r,2*Math.PI*(a>>3)/e),c=r.clone().cross(l).normalize(),h=new P(a&1?s.x:n.x,a&2?s.y:n.y,a&4?s.z:n.z).sub(this.middle);return[h.dot(c),h.dot(l.clone().cross(c)),h.dot(l)]})}shiftFor(t){if(this.camera===this.orthographic)return 0;let[,e]=this.freePart(),n=this.corners(t,Am),s=Math.max(...n.map(([,o,a])=>Math.abs(o)/e/oo+a)),r=n.map(([,o,a])=>o/(s-a)/oo);return(Math.max(...r)+Math.min(...r))/2}limit(){let{controls:t,middle:e}=this,n=t.target.clone().sub(e),s=this.camera.position.clone().sub(t.target),r=s.length(),o=n.dot(s)/r,a=o**2+(LM*this.radius)**2-n.lengthSq();t.minDistance=Math.max(0,Math.sqrt(Math.max(0,a))-o),this.camera===this.perspective&&r<.999*t.minDistance&&t.update()}adapt(t){this.slow=t>AM&&t<Sm?this.slow+1:0,this.slow>=TM&&this.setResolution(CM),clearTimeout(this.resting),this.resolution!==1&&(this.resting=setTimeout(()=>{this.setResolution(1),this.drawNow()},Sm))}setResolution(t){t!==this.resolution&&(this.resolution=t,this.setSize())}setSize(){let{canvas:t,height:e,renderer:n,width:s}=this,r=this.resolution*Math.min(devicePixelRatio,2);t.width===Math.floor(s*r)&&t.height===Math.floor(e*r)||n.setDrawingBufferSize(s,e,r)}visibleSize(){return this.camera===this.orthographic?this.radius/this.orthographic.zoom:this.camera.position.distanceTo(this.controls.target)*oo}get scale(){if(this.fitted!==null)return 1;let{offset:t,zoom:e}=this.fittedPlace(this.towardsCamera);return this.camera===this.orthographic?this.orthographic.zoom/e:t.radius/this.camera.position.distanceTo(this.controls.target)}resize(){let{scale:t}=this;this.width=Math.max(1,this.stage.clientWidth),this.height=Math.max(1,this.stage.clientHeight),this.covered=UM(this.stage),this.refit(t)}refit(t){let{controls:e,fitted:n,orthographic:s}=this;this.setSize();let r=this.fittedPlace(n===null||this.spinning?this.towardsCamera:n);e.maxDistance=r.offset.radius/wm,e.minZoom=r.zoom*wm,e.maxZoom=r.zoom*PM,this.setFrame(),this.turning!==null?this.turning.to=r:n!==null?this.setPlace(r):(this.camera===s&&(s.zoom=t*r.zoom),this.camera.position.sub(e.target).setLength(r.offset.radius/(this.camera===s?1:t)).add(e.target),this.limit(),this.setFrame()),this.draw()}setFrame(){let{height:t,orthographic:e,perspective:n,radius:s,width:r}=this,o=r/t;n.aspect=o,n.near=s/100,n.far=s*100,e.top=s,e.bottom=-s,e.right=s*o,e.left=-s*o,e.near=-s*100,e.far=s*100,this.centre()}centre(){let{camera:t,height:e,width:n}=this,{left:s,top:r,right:o,bottom:a}=this.margins(),l=this.shiftFor(t.position.clone().sub(this.controls.target)),c=(o-s)/2,h=(a-r-l*e)/2;t.setViewOffset(n,e,c,h,n,e)}};function UM(i){let t=i.getBoundingClientRect(),e={...Rm};for(let n of i.querySelectorAll("[data-edge]")){let s=n.getBoundingClientRect();s.width===0||s.height===0||(n.dataset.edge==="top"?e.top=Math.max(e.top,s.bottom-t.top):e.right=Math.max(e.right,t.right-s.left))}return e}function FM(i,t,e){let n=(r,o)=>_i.lerp(r,o,e),s=_i.euclideanModulo(t.offset.theta-i.offset.theta+Math.PI,2*Math.PI)-Math.PI;return{target:i.target.clone().lerp(t.target,e),offset:new kn(n(i.offset.radius,t.offset.radius),n(i.offset.phi,t.offset.phi),i.offset.theta+e*s),zoom:i.zoom*(t.zoom/i.zoom)**e}}var Lm=new URL("examples/",import.meta.url),Pm=null;async function $l(){return(await Nm()).examples}async function Dm(i,t){if(qt!==null){let[e,n]=qt.gamuts;return e?.gamut.id===i&&n?.gamut.id===t&&qt.coverage||void 0}return(await Nm()).comparisons?.find(e=>e.a===i&&e.b===t)}function Nm(){return qt!==null?Promise.resolve({examples:[]}):(Pm??=Xl("index.json").then(async i=>await i.json()).catch(()=>({examples:[]})),Pm)}async function Xl(i){let t=await fetch(new URL(i,Lm));if(!t.ok)throw new Error(`The file ${i} of the page is missing.`);return t}async function ao(i){return(await $l()).find(t=>t.key===i)}async function Um(i,t){let e=await(await Xl(`${i.key}.json`)).json();return wd(e.id,async()=>{let n=t(),{signal:s}=new AbortController;try{return i.file===null?(await So(i.key,n.report,s)).id:await Mo(await Cu(i),{},n.report,s)}finally{n.end()}}),e}var Im=null;function Fm(){return Im??=$l().then(async i=>{let t=i.map(async({key:e})=>[(await(await Xl(`${e}.json`)).json()).id,e]);return new Map(await Promise.all(t))}),Im}function Om(i){return new URL(`${i.key}.gamut`,Lm).href}async function Cu({file:i}){return i===null?null:new File([await(await Xl(i)).blob()],i)}var OM=250,ql=class{parts=[];saving=0;isPaused=!1;add(t){this.parts.push(t)}read(){let t=new URLSearchParams(location.hash.slice(1)||qt?.state?.address);for(let e of this.parts)e.read(t);return t}get text(){return this.parts.flatMap(t=>t.write()).filter(t=>t[1]!==null).map(([t,e])=>`${t}=${encodeURIComponent(e).replaceAll("%2C",",")}`).join("&")}save(){this.saving===0&&(this.saving=setTimeout(()=>{this.saving=0,this.saveNow()},OM))}saveNow(){this.isPaused||location.protocol==="about:"||history.replaceState(null,"",`#${this.text}`)}};var be=class{current=null;get isAsking(){return this.current!==null}end(){this.current?.abort(),this.current=null}async ask(t,e,n){this.end();let s=new AbortController;this.current=s;let r;try{let o=await t(s.signal);r=()=>e(o)}catch(o){r=()=>n(o)}this.current===s&&(this.current=null,r())}};var Ru={upload:["Sending the file",0],waiting:["Waiting for its turn",.05],characterisation:["Reading the data",.06],colours:["Computing colours",.1],boundary:["Finding the surface",.3],decimation:["Making all levels of detail",.45],metric:["Measuring the levels",.85],encoding:["Storing the result",.96]},BM=1e3,kM=6e3,Yl=class{constructor(t,e,n,s){this.board=t;this.name=e;if(this.row=document.querySelector(`.gamut-row[data-slot="${n}"]`),this.box=tt("div","",{className:"work"}),this.bar.setAttribute("aria-label",`Progress of ${e}`),s===null){this.box.append(tt("strong",e),this.line,this.bar);return}let r=tt("button","Cancel",{type:"button",className:"cancel"});r.setAttribute("aria-label",`Cancel ${e}`),r.addEventListener("click",()=>{s(this.job),this.end(),t.note(`${e} was cancelled.`)}),this.box.append(tt("strong",e),r,this.line,this.bar)}board;name;report=(t,e,n)=>{this.job=n;let s=Ru[t]??[t,0];this.box.isConnected||(this.row.querySelector(".waiting").append(this.box),this.row.hidden=!1),t!==this.stage&&(this.stage=t,this.entered=Date.now(),this.words=s[0],this.board.announce(`${this.name}: ${this.words}`));let o=Object.values(Ru).map(([,a])=>a).find(a=>a>s[1])??1;this.bar.value=s[1]+(o-s[1])*e,this.percent=t==="upload"?` ${Math.round(100*e)} %`:"",this.isWaiting=t==="waiting"||t==="upload"&&e===1,this.tell()};job="";box;row;line=tt("span");bar=tt("progress","",{max:1});clock=setInterval(()=>this.tick(),500);begun=Date.now();stage="";words="";percent="";isWaiting=!1;entered=0;end(){clearInterval(this.clock),this.box.remove()}tick(){this.stage!==""&&(this.tell(),!(!this.isWaiting||Date.now()-this.entered<BM)&&ir().then(t=>{if(!this.isWaiting)return;this.words=t??Ru.waiting[0];let[,e,n]=/(\d+) of (\d+) kernels/.exec(this.words)??[];n!==void 0&&(this.bar.value=Number(e)/Number(n)),this.percent=""}))}tell(){let t=Math.floor((Date.now()-this.begun)/1e3);this.line.textContent=`${this.words}${this.percent} · ${t} s`}},jl=class{constructor(t){this.announce=t}announce;leaving=0;begin(t,e,n){return new Yl(this,t,e,n)}prepare(t,e){return new Yl(this,`Preparing answers about ${t}`,e,null)}note(t,e=!1){let n=L("stage-note");clearTimeout(this.leaving),n.hidden=t===null,t!==null&&!e&&(this.leaving=setTimeout(()=>this.note(null),kM)),!(t===null||t===n.textContent)&&(n.textContent=t,this.announce(t))}};var Pu=["reference_white","adapting_luminance","background","surround"];function Zl(i,t){let[e,n]=[i,t].map(({provenance:s})=>s.colour_space);return i.options.space===t.options.space&&Pu.every(s=>e?.[s]===void 0||n?.[s]===void 0||e[s]===n[s])}function km({options:i,provenance:t}){let e={...t.colour_space,...i},n=i.space==="CIELAB"&&e.reference_white==="D50",s=Pu.filter(r=>!n&&e[r]!==void 0);return Object.fromEntries([["space",i.space],...s.map(r=>[r,String(e[r])])])}function Bm(i,t){let[e,n]=[i,t].map(({provenance:o})=>o.colour_space),r=Pu.filter(o=>i.options.space===t.options.space&&e?.[o]!==n?.[o]).map(o=>`${o.replace("_"," ")} ${e?.[o]??"not stated"}`);return[i.options.space,...r].join(", ")}function Iu(i,t){let[e,n]=[Bm(i,t),Bm(t,i)];return new oe({title:"Different spaces",detail:`${i.name} is in ${e}. ${t.name} is in ${n}. Their coordinates do not fit one set of axes.`,remedy:`Build ${i.name} again with the space ${n}, or remove ${t.name}.`,code:"",status:0,where:null})}var ue=["a","b","c","d","e","f"],zM={a:["#000000","#ffffff"],b:["#0072b2","#56b4e9"],c:["#d55e00","#e69f00"],d:["#009e73","#009e73"],e:["#cc79a7","#cc79a7"],f:["#e69f00","#f0e442"]};function Ze(i,t){return zM[i][t?1:0]}var HM=Dd(),zm=1e4,GM=1e3,Jl=.3,Hm={solid:1,shaded:1,both:1,shell:Jl,wire:.05},Kl=class{canvas=L("view");view=new Wl(this.canvas,L("stage"));address=new ql;hidden=new Set;opacities=new Map;hasEdges=!1;solid="a";containment=new Map;kept=new Map;files=new Map;building=Gm();triangles=zm;hasAxes=!0;board=new jl(t=>this.announce(t));isTrial=!1;readable=[];gamuts=new Map;wanted=new Map;camera=null;own=/\/v1\/gamuts\/([^/]+)$/.exec(location.pathname)?.[1];opening=Gm();materials=Object.fromEntries(ue.map(t=>[t,new Il]));listeners=new Map;dark=matchMedia("(prefers-color-scheme: dark)");extentKey="";levels=0;marks={};constructor(){this.view.onMove=()=>this.emit("camera"),this.dark.addEventListener("change",()=>this.emit("theme")),this.on(["theme"],()=>{this.fit(),this.applyLooks()}),this.address.add({read:t=>{let e=Number(t.get("triangles"));Number.isInteger(e)&&e>=4&&(this.triangles=e);for(let n of ue)this.readLook(n,t.get(`style-${n}`),Number(t.get(`opacity-${n}`)??NaN))},write:()=>[...ue.map(t=>[t,this.keyOf(t)??(t==="a"&&this.own?"":null)]),["triangles",String(this.triangles)],...this.shown.flatMap(({slot:t})=>[[`style-${t}`,this.hidden.has(t)?"hidden":null],[`opacity-${t}`,this.opacities.get(t)?.toString()??null]])]}),this.address.add({read:()=>{},write:()=>[["camera",(this.view.isHome?this.camera:this.view.place)?.join(",")??null]]}),this.on(["slots","looks","requests","level","camera"],()=>this.address.save())}on(t,e){for(let n of t)this.listeners.set(n,[...this.listeners.get(n)??[],e])}emit(t){for(let e of this.listeners.get(t)??[])e()}get shown(){return ue.flatMap(t=>this.gamuts.get(t)??[])}at(t){return this.gamuts.get(t)??null}get isEmpty(){return this.gamuts.size===0&&this.wanted.size===0}keyOf(t){return this.at(t)?.key??this.wanted.get(t)}get finest(){return Math.max(4,...this.shown.map(({gamut:t})=>t.counts.triangles))}get isDark(){let t=document.documentElement.dataset.theme;return t===void 0?this.dark.matches:t==="dark"}get figures(){let{memory:t}=this.view.renderer.info,[e,n,...s]=ue.map(o=>this.at(o)?.layer),r=[e,n,...s.filter(o=>o!==void 0)];return{frames:this.view.frames,levels:this.levels,marks:this.marks,geometries:t.geometries,textures:t.textures,triangles:r.map(o=>o?.level?.triangles??0),available:r.map(o=>o?.available??0),withDevice:r.map(o=>o?.level?.device!=null)}}async restore(){let t=this.address.read();this.camera=t.get("camera")?.split(",").map(Number)??null;let e=this.own,n=new Map(ue.map(a=>[a,t.get(a)]));qt!==null&&ue.every(a=>n.get(a)==null)?qt.gamuts.forEach(({gamut:a},l)=>n.set(ue[l],a.id)):e!==void 0&&n.get("a")==null&&n.set("a",decodeURIComponent(e));let s=document.getElementById("static");[e,s?.dataset.gamut].includes(n.get("a")??void 0)||s?.remove(),this.complain(null),this.wanted.clear();for(let[a,l]of n)l&&this.wanted.set(a,l);let[r,...o]=[...this.wanted].map(([a,l])=>async()=>{this.wanted.get(a)===l&&await this.load(a,l)});await r?.(),await Promise.all(o.map(a=>a())),this.camera!==null&&this.view.isHome&&this.shown.length>0&&this.view.restore(this.camera),this.emit("slots")}async show(t,e,n=!1){if(this.isTrial=!1,this.camera=null,this.complain(null),this.building[t].end(),e!==null)return this.load(t,e,n);this.opening[t].end(),this.wanted.delete(t),this.remove(t),this.fit(),this.applyLooks(),this.emit("slots")}async load(t,e,n=!1){let s=this.opening[t];this.wanted.set(t,e),await s.ask(r=>{let o=this.board.begin(e.length===64?"The gamut":e,t,()=>{s.end(),this.wanted.delete(t),this.emit("requests")});return r.addEventListener("abort",()=>o.end()),this.find(t,e,n,o,r).finally(()=>o.end())},r=>this.put(t,e,r),r=>{this.complain(r),this.emit("requests")})}put(t,e,{gamut:n,source:s,isPart:r}){this.remove(t);let o=Se(n),a=new Ll(HM,s,_u(n),o,Xp(n.options.space,o),Math.min(this.triangles,n.counts.triangles),this.materials[t],{level:()=>this.levelArrived(a),received:l=>{l&&(this.marks.complete=performance.now()),this.emit("level");let c=r&&this.triangles>Math.max(zm,a.available),h=this.shown.find(d=>d.layer===a)?.slot;l&&c&&h!==void 0&&this.load(h,e,!0)},failed:l=>this.complain(new Error(`${n.name} could not be loaded. Open the page again. (${l})`))});this.wanted.delete(t),this.gamuts.set(t,{slot:t,key:e,gamut:n,layer:a,isPart:r}),this.view.scene.add(a.group),this.followFirst(),this.fit(),this.applyLooks(),this.emit("slots")}async find(t,e,n,s,r){let o=qt?.gamuts.find(({gamut:p})=>p.id===e);if(o!==void 0)return{gamut:o.gamut,source:{bytes:o.history},isPart:!1};let a=await ao(e),l=a&&await Um(a,()=>this.board.prepare(a.name,t)),{anchor:c}=this.beside(t);if(a!==void 0&&!n&&(c===void 0||Zl(l,c)))return{gamut:l,source:{address:Om(a),headers:{},isShort:!0},isPart:!0};let h=a?.file?l.id:e,d=c!==void 0&&WM(h)&&!h.includes("?")?km(c):{},u=await So(h,s.report,r,d),{anchor:f,isFirst:g}=this.beside(t);if(f!==void 0&&!g&&!Zl(u,f)){if(f.id!==c?.id)return this.find(t,e,n,s,r);throw Iu(u,f)}let x={address:ji(`/v1/gamuts/${u.id}/history`),headers:bo()};return{gamut:u,source:x,isPart:!1}}beside(t){let e=this.shown.filter(s=>s.slot!==t),n=e.every(s=>s.slot>t);return{anchor:e.find(({gamut:s})=>!n||s.provenance.reference===void 0)?.gamut,isFirst:n}}followFirst(){let[t,...e]=this.shown;for(let{slot:n,key:s,gamut:r}of e)Zl(r,t.gamut)||(this.remove(n),r.provenance.reference!==void 0?this.load(n,s.split("?")[0]):this.complain(Iu(r,t.gamut)))}setTriangles(t){let e=2*Math.floor(Math.min(Math.max(t,4),this.finest)/2);this.triangles=e;for(let{slot:n,key:s,layer:r,isPart:o}of this.shown)r.setTriangles(e),o&&e>r.available&&r.available>0&&this.load(n,s,!0);this.emit("level")}lookOf(t){let e=this.opacities.get(t)??(t===this.solid?1:Jl);return{isVisible:!this.hidden.has(t),opacity:e,hasEdges:this.hasEdges}}setVisible(t,e){e?this.hidden.delete(t):this.hidden.add(t),this.changeLooks()}setOpacity(t,e){this.opacities.set(t,Math.min(1,Math.max(.05,e))),this.changeLooks()}setEdges(t){this.hasEdges=t,this.changeLooks()}readLook(t,e,n){e==="hidden"&&this.hidden.add(t),e!==null&&e in Hm&&this.opacities.set(t,Hm[e]),e==="both"&&(this.hasEdges=!0),n>0&&n<=1&&this.opacities.set(t,n)}chooseSolid(){let[t,...e]=this.shown;return e.filter(s=>this.isInside(s,t)).sort((s,r)=>s.gamut.volume-r.gamut.volume)[0]?.slot??t?.slot??"a"}isInside(t,e){let n=`${t.gamut.id} ${e.gamut.id}`,s=this.containment.get(n),r=({gamut:a,layer:l})=>(l.level?.triangles??0)>=Math.min(GM,this.triangles,a.counts.triangles);if(s!==void 0||t.gamut.volume>e.gamut.volume||!r(t)||!r(e))return s??!1;let o=xm(t.layer.level,e.layer.level);return this.containment.set(n,o),o}setAxes(t){this.hasAxes=t,this.fit(),this.view.draw(),this.address.save()}async sourceOf(t){let e=await ao(this.at(t)?.key??"");return e===void 0?null:Cu(e)}announce(t){L("status").textContent=t}complain(t,e=""){let n=L("problem");n.hidden=t===null,n.replaceChildren(),t!==null&&(n.append(...si(t,e)),VM(t)&&(L("key-field").hidden=!1))}changeLooks(){this.applyLooks(),this.emit("looks")}applyLooks(){this.solid=this.chooseSolid();for(let{slot:e,layer:n}of this.shown)n.setLook(this.lookOf(e),Ze(e,this.isDark),this.materials[e]);[...this.shown].sort((e,n)=>e.gamut.volume-n.gamut.volume).forEach(({layer:e},n)=>e.setRank(n)),this.view.draw()}remove(t){this.gamuts.get(t)?.layer.dispose(),this.gamuts.delete(t)}levelArrived(t){this.levels+=1;let{gamut:e}=this.shown.find(s=>s.layer===t),n=t.level.triangles===e.counts.triangles;if(this.levels===1||n){this.view.drawNow();let s=performance.now();n&&(this.marks.whole=s),this.levels===1&&(document.getElementById("static")?.remove(),Object.assign(this.marks,{first:s,firstTriangles:t.level.triangles,firstBytes:t.bytes}))}this.chooseSolid()!==this.solid&&this.changeLooks(),this.emit("level"),this.view.draw()}fit(){let t=new ve;for(let{gamut:a}of this.shown){let l=yn(Se(a)),[c,h]=a.bounds,d=new ve(new P().fromArray(c),new P().fromArray(h));t.union(d.applyMatrix4(l))}let e=this.shown[0],n=this.hasAxes&&e!==void 0,s=e===void 0?[]:Se(e.gamut),{color:r}=getComputedStyle(document.body),o=JSON.stringify([t,s,n,r]);o!==this.extentKey&&(this.extentKey=o,this.view.setExtent(e===void 0?null:t,n?new Bl(gm(s),t,r):null))}};function Gm(){return Object.fromEntries(ue.map(i=>[i,new be]))}function VM(i){return i instanceof oe&&[401,403].includes(i.problem.status)}function WM(i){return!/^[0-9a-f]{64}$/.test(i)}function Se(i){return i.provenance.colour_space?.axes??i.provenance.axes?.split(" ")??["L*","a*","b*"]}var Wm="http://www.w3.org/2000/svg",Vm=36,$M=[12,8];function $m(i,t){let e=L("gizmo").querySelector("svg"),n="",s=[],r=()=>{let a=t(),l=a.map(({name:c})=>c).join();l!==n&&(n=l,s=a.map(({name:c,side:h,direction:d},u)=>{let f=document.createElementNS(Wm,"g"),g=u%2===0;return f.dataset.axis=c,f.append(Ql("title",{},`From ${h} (${c}), key ${u+1}`),Ql("circle",{r:$M[g?0:1]}),...g?[Ql("text",{dy:"0.35em"},c.slice(1))]:[]),f.addEventListener("click",()=>i.view.lookAlong(d)),{mark:f,line:g?Ql("line",{x1:50,y1:50}):null,direction:d}}),o())},o=()=>{let{camera:a}=i.view;a.updateMatrixWorld();let l=s.map(c=>({...c,at:c.direction.clone().normalize().transformDirection(a.matrixWorldInverse)}));l.sort((c,h)=>c.at.z-h.at.z);for(let{mark:c,line:h,at:d}of l){let[u,f]=[50+Vm*d.x,50-Vm*d.y];c.setAttribute("transform",`translate(${u.toFixed(1)} ${f.toFixed(1)})`),h?.setAttribute("x2",u.toFixed(1)),h?.setAttribute("y2",f.toFixed(1))}e.replaceChildren(...l.flatMap(({mark:c,line:h})=>h===null?[c]:[h,c]))};L("home").addEventListener("click",()=>i.view.home()),i.on(["slots"],r),i.view.onDraw.push(o)}function Ql(i,t,e=""){let n=document.createElementNS(Wm,i);for(let[s,r]of Object.entries(t))n.setAttribute(s,String(r));return n.textContent=e,n}var tc=Math.PI/36,Lu=1.15;function qm(i){let{view:t,canvas:e}=i,n=L("keys");L("help").addEventListener("click",()=>n.showModal()),$m(i,()=>Xm(i));let s={ArrowLeft:()=>t.turn(-tc,0),ArrowRight:()=>t.turn(tc,0),ArrowUp:()=>t.turn(0,-tc),ArrowDown:()=>t.turn(0,tc),"+":()=>t.enlarge(Lu),"=":()=>t.enlarge(Lu),"-":()=>t.enlarge(1/Lu),0:()=>t.home(),"[":()=>i.setTriangles(i.triangles/2),"]":()=>i.setTriangles(i.triangles*2),PageUp:()=>Tl(5),PageDown:()=>Tl(-5),p:()=>{let r=L("projection");r.value=r.value==="perspective"?"orthographic":"perspective",r.dispatchEvent(new Event("change"))},w:()=>i.setOpacity("a",i.lookOf("a").opacity<1?1:Jl),a:()=>L("axes").click(),"?":()=>n.showModal()};e.addEventListener("keydown",r=>{if(r.ctrlKey||r.metaKey||r.altKey)return;let o=Xm(i)[Number(r.key)-1]?.direction,a=r.key.length===1?r.key.toLowerCase():r.key,l=o===void 0?s[a]:()=>t.lookAlong(o);l!==void 0&&(r.preventDefault(),l())})}var XM=[["the right","the left"],["above","below"],["the front","the back"]];function Xm(i){let t=i.shown[0];if(t===void 0)return[];let e=Se(t.gamut),n=yn(e);return e.flatMap((s,r)=>[1,-1].map(o=>{let a=new P().setComponent(r,o).applyMatrix4(n),l=a.toArray().findIndex(h=>h!==0),c=XM[l][a.getComponent(l)>0?0:1];return l===1&&(a.z+=.001),{name:`${o>0?"+":"−"}${s}`,side:c,direction:a}}))}var lo=null,Ym=()=>lo?.scrollIntoView({block:"nearest"});function ec(i){lo=L(i),lo.open=!0,Ym()}function jm(){let i=L("panel"),t=new ResizeObserver(Ym);for(let n of i.querySelectorAll(".part"))t.observe(n),n.firstElementChild.addEventListener("click",()=>{lo=n.open?null:n});let e=()=>lo=null;for(let n of["wheel","touchmove"])i.addEventListener(n,e,{passive:!0});i.addEventListener("pointerdown",({target:n})=>n===i&&e()),i.addEventListener("keydown",({key:n})=>/^(Page|Home|End|Arrow)/.test(n)&&e())}var qM={press:"A press",photo:"A photograph",bt2020:"BT.2020"},Du=["press","srgb"],YM=2e3;async function Km(i){let t=qt===null&&location.hash.length<2&&!location.pathname.includes("/v1/gamuts/");i.address.isPaused=t;let e=$l(),n=i.restore();if(jM(i,await e),await n,!t)return Zm(i);let s=()=>{i.address.isPaused=!1,i.address.saveNow()};if(!i.isEmpty)return s();let r=(await e).map(({key:h})=>h),[o,a]=r.includes(Du[0])?Du:[Du[1],null],l=new AbortController,{signal:c}=l;for(let h of["pointerdown","keydown","wheel","drop"])addEventListener(h,()=>l.abort(),{capture:!0,passive:!0,signal:c});c.addEventListener("abort",()=>{i.view.spin(!1),s()}),await Promise.all([i.show("a",o),a!==null&&i.show("b",a)]),i.isTrial=i.at("a")?.key===o&&(i.at("b")?.key??null)===a,i.isTrial||l.abort(),i.view.spin(!c.aborted),Zm(i),ZM(i)}function Zm(i){let t=L("invitation"),e=()=>{let n=!L("problem").hidden;t.hidden=i.shown.length>0||!(i.isEmpty||n),t.textContent=`${n?"This gamut cannot be shown. ":""}Drop a profile, or choose a gamut.`,t.hidden||document.getElementById("static")?.remove()};i.on(["slots","requests"],e),e()}function jM(i,t){let e=L("chips");e.replaceChildren(...t.map(({key:r,name:o,text:a,file:l})=>{let c=tt("span","",{className:"chip"}),h=tt("button",qM[r]??o,{type:"button",title:l===null?a:`${o}. ${a}`}),d=tt("button","+",{type:"button",title:`${o} as the second gamut`});return d.setAttribute("aria-label",`${o} as the second gamut`),h.addEventListener("click",({shiftKey:u})=>{i.show(u?"b":"a",r)}),d.addEventListener("click",()=>{i.show("b",r)}),h.dataset.key=r,c.append(h,d),c}));let n=new Map,s=()=>{i.shown.some(({key:o,gamut:a})=>o===a.id)&&n.size===0&&t.length>0&&Fm().then(o=>{n=o,o.size>0&&s()},()=>{});for(let o of e.querySelectorAll("[data-key]"))o.setAttribute("aria-pressed",String(i.shown.some(({key:a,gamut:l})=>[a,n.get(l.id)].includes(o.dataset.key))))};i.on(["slots"],s),s(),e.hidden=t.length===0}async function ZM(i){let t=L("preparation");for(let e=await ir(!0);e!==null;e=await ir(!0)){let[,n,s]=/(\d+) of (\d+) kernels/.exec(e)??[],r=t.querySelector("progress");r.hidden=s===void 0,s!==void 0&&Object.assign(r,{max:Number(s),value:Number(n)}),t.querySelector("span").textContent=`${e}.`,t.hidden&&i.announce(`${e}. The examples can be looked at meanwhile.`),t.hidden=!1,await new Promise(o=>setTimeout(o,YM))}t.hidden||i.announce("The service is ready."),t.hidden=!0}var Nu={relative:"Relative: the white of the medium counts as the white of the space.",absolute:"Absolute: the white of the medium keeps its colour, as in measured spot colours.",perceptual:"Perceptual: as an ICC profile renders pictures.",saturation:"Saturation: as an ICC profile renders graphics."},KM={reflective:"Print or another reflecting medium",unknown:"Not stated",output:"Printer or press",input:"Scanner or camera"};function Si({options:i}){return i.space==="CIELAB"?"cubic ΔE*ab":`cubic units of ${i.space}`}function Ys({volume:i}){return i.toLocaleString("en",{maximumSignificantDigits:4})}function Jm({options:i,provenance:t}){let{colour_space:e,ink_limits:n,white:s,white_lab:r,medium:o}=t,a=o??t.device_class,l=[["Intent",Nu[t.intent??""]??"As given: the colours are not converted.","How the white of the medium is treated. Colours as measured, such as spot colours, need the absolute intent."]];if(n===void 0)l.push(["Ink limit","None","Largest sum of all inks. Four full inks are 400 %."]);else{let f=g=>g===null?"None":`${g} %`;l.push(["Ink limit",f(n.total),"Largest sum of all inks. Four full inks are 400 %."]),n.black!==null&&l.push(["Black limit",f(n.black),"Largest amount of the black ink."])}let c=a?KM[a]??a[0].toUpperCase()+a.slice(1):t.reference?"Reference":"Not stated";if(l.push(["Medium",c,"What shows or carries the colours."]),r||s){let f=t.white_luminance,g=r?`L*a*b* ${nc(r)}`:`X Y Z ${nc(s)}`,x=[t.illuminant,t.observer].filter(p=>p&&!p.startsWith("none"));l.push(["White",g+(f===void 0?"":`, ${nc([f])} cd/m²`),`White of the medium or display${x.length>0?` (${x.join(", ")})`:""}.`])}else l.push(["White","Not stated","White of the medium or display."]);let d=[["luminance",e?.luminance," cd/m²"],["adapting luminance",e?.adapting_luminance," cd/m²"],["background",e?.background," %"],["surround",e?.surround,""]].flatMap(([f,g,x])=>g===void 0?[]:[`${f} ${typeof g=="number"?nc([g]):g}${x}`]),u=e?.reference_white;return l.push(["Space",[i.space,...u===void 0?[]:[`white ${u}`],...d].join(", "),"Coordinates of the boundary, their reference white and viewing conditions."]),l}function nc(i){return i.map(t=>je(t,4)).join(" ")}function Qm({options:i,provenance:t}){let e=t.ink_limits?.total??null;return{intent:t.intent??"",space:i.space,...e===null?{}:{ink_limit:e}}}function JM({intent:i,ink_limit:t,space:e}){return[i===""?"Colours as given":i[0].toUpperCase()+i.slice(1),t===void 0?"no ink limit":`ink limit ${t} %`,e].join(" · ")}var ic=class{constructor(t){this.apply=t;for(let e of document.querySelectorAll(".gamut-row")){let n=e.dataset.slot,s=tt("p","",{className:"options-line",hidden:!0}),r=tt("button","Change",{type:"button",className:"link"});r.setAttribute("aria-expanded","false"),r.setAttribute("aria-label",`Change the options of the gamut ${n.toUpperCase()}`),r.addEventListener("click",()=>this.slot===n?this.close():this.open(n)),s.append(tt("span")," ",r),e.append(s),this.lines.set(n,s)}this.form.addEventListener("submit",e=>{e.preventDefault();let n=this.slot;this.close(),this.apply(n,this.chosen)}),L("options-close").addEventListener("click",()=>this.close()),this.intent.addEventListener("change",()=>this.explain())}apply;form=L("options");intent=L("intent");limit=L("ink-limit");space=L("space");lines=new Map;slot=null;get chosen(){let t=this.limit.value===""||!this.limit.checkValidity()?{}:{ink_limit:this.limit.valueAsNumber};return{intent:this.intent.value,space:this.space.value,...t}}state(t,e,n){let s=this.lines.get(t);s.hidden=e===null&&n===null,s.hidden&&this.slot===t&&this.close(),s.dataset.options=JSON.stringify(n??e),s.firstElementChild.textContent=e===null?"":JM(e)}open(t){this.close(),this.slot=t;let e=this.lines.get(t),n=JSON.parse(e.dataset.options??"null");n!==null&&(this.intent.value=n.intent||"relative",this.space.value=n.space,this.limit.value=n.ink_limit===void 0?"":String(n.ink_limit)),e.after(this.form),this.form.hidden=!1,e.querySelector("button").setAttribute("aria-expanded","true"),this.explain(),this.intent.focus()}close(){if(this.slot===null)return;let t=this.lines.get(this.slot).querySelector("button");t.setAttribute("aria-expanded","false"),this.form.contains(document.activeElement)&&t.focus(),this.form.hidden=!0,this.slot=null}explain(){L("intent-note").textContent=Nu[this.intent.value]}};var QM=[["picture",/^image\//],["colours",/^text\/(csv|plain|tab-separated-values)$|application\/vnd.ms-excel/]],sc=class{constructor(t,e){this.page=t;this.checks=e;let n=L("file");L("upload").addEventListener("click",()=>{this.purpose=null,n.click()}),n.addEventListener("change",()=>{let s=[...n.files??[]];n.value="",this.purpose!==null&&s[0]!==void 0?this.upload(s[0],this.purpose.slot,this.purpose.options):this.take(s,s.length===1?this.free:"a")}),this.connectDrop(),L("key").addEventListener("change",s=>{Sd(s.target.value.trim()),t.complain(null),t.restore()}),t.on(["slots","requests"],()=>this.refresh())}page;checks;options=new ic((t,e)=>{this.change(t,e)});uploads=new Map;purpose=null;get free(){return[...document.querySelectorAll(".gamut-row:not([hidden])")].map(({dataset:e})=>e.slot).find(e=>(this.page.at(e)===null||this.page.isTrial)&&!this.isBusy(e))??"a"}isBusy(t){return this.of(t)?.isRefused===!1}of(t){return this.uploads.get(this.page.building[t])}refresh(){for(let t of ue){let e=this.page.at(t)?.gamut,n=this.of(t);n?.isRefused&&n.refused!==e?.id&&this.uploads.delete(this.page.building[t]),this.options.state(t,e===void 0?null:Qm(e),this.of(t)?.options??null)}}take(t,e){let n=ue.slice(ue.indexOf(e));t.slice(0,n.length).forEach((s,r)=>{this.upload(s,n[r],this.options.chosen)}),t.length>n.length&&this.page.board.note(`The page shows ${ue.length} gamuts; the other files are left out.`)}async change(t,e){let{page:n}=this,s=n.at(t)?.gamut,r=this.of(t)?.file??n.files.get(s?.id??"");await n.building[t].ask(async()=>r??n.sourceOf(t),a=>{let l=s?.provenance.reference;a!==null?this.upload(a,t,e):l!==void 0?n.show(t,`${l}?${new URLSearchParams({intent:e.intent,space:e.space})}`):(this.purpose={slot:t,options:e},n.board.note(`Choose the file of ${s?.name??"the gamut"} again: it is built with the new options.`),L("file").click())},a=>n.complain(a))}async upload(t,e,n){let{page:s}=this,r=s.building[e];r.end();let o={file:t,options:n,isRefused:!1};this.uploads.set(r,o),s.complain(null),s.emit("requests"),await r.ask(a=>{let l=s.board.begin(t.name,e,c=>{c!==""&&Cd(c).catch(()=>{}),r.end()});return a.addEventListener("abort",()=>{l.end(),this.uploads.delete(r),this.refresh()}),Mo(t,n,l.report,a).finally(()=>l.end())},a=>{s.files.set(a,t),this.uploads.delete(r),this.show(e,a,t.name)},a=>{s.complain(a,t.name),o.isRefused=a instanceof oe,o.refused=s.at(e)?.gamut.id,o.isRefused||this.uploads.delete(r),this.refresh(),a instanceof oe&&a.problem.code==="invalid-option"&&this.options.open(e)})}async show(t,e,n){await this.page.show(t,e),this.page.at(t)?.key===e&&this.page.announce(`${n} is shown`)}connectDrop(){let t=L("drop"),e=0,n=null,s=t.querySelector("p"),r={check:L("drop-check"),build:L("drop-build")},o=null,a=null,l=({dataTransfer:u})=>{let f=[...u?.items??[]].map(({type:x})=>x),g=QM.find(([,x])=>f.length===1&&x.test(f[0]))?.[0];o=g===void 0||this.checks[g].against===null?null:this.checks[g],s.hidden=o!==null,r.check.hidden=r.build.hidden=o===null,r.check.textContent=o===null?"":`Check against ${o.against}`},c=u=>{n?.classList.remove("aimed"),a?.classList.remove("aimed"),n=u instanceof Element?u.closest(".gamut-row"):null,a=u instanceof Element?u.closest(".drop-target"):null,n?.classList.add("aimed"),a?.classList.add("aimed");let f=n?.querySelector("label")?.textContent.toLowerCase();s.textContent=f?`Drop to build the ${f}`:"Drop to build the first gamut; more files become the next ones"},h=({dataTransfer:u})=>u?.types.includes("Files")??!1,d=()=>{e=0,t.hidden=!0,n?.classList.remove("aimed"),a?.classList.remove("aimed")};addEventListener("dragenter",u=>{h(u)&&(e+=1,t.hidden&&l(u),t.hidden=!1,c(u.target))}),addEventListener("dragleave",()=>{e-=1,e<=0&&d()}),addEventListener("dragover",u=>h(u)&&u.preventDefault()),addEventListener("drop",u=>{if(!h(u))return;u.preventDefault(),c(u.target),d();let f=[...u.dataTransfer?.files??[]];if(a===r.check&&o!==null&&f[0]!==void 0)return o.take(f[0]);this.take(f,n?.dataset.slot??"a")})}};var js="%";function Uu(i){return i.map(t=>Math.round(1e3*t)/10)}function Fu(i,t,e=" "){return i.map((n,s)=>`${n} ${Math.round(100*t[s])}`).join(e)}function Ou(i,t){return`${Fu(i,t,"  ")} ${js}`}function rc({black_least:i,black_most:t},e){let n=[i?.[e],t?.[e]].flatMap(s=>s==null?[]:[Math.round(100*s)]);return n.length===0?null:[...new Set(n)].join("–")}function oc(i){return i.find(t=>/^(k|black)$/i.test(t))??"black"}async function tg(i,t,e){let n=new URLSearchParams({a:i,b:t,lost:"true"});return await(await Ee(`/v1/comparisons?${n}`,{signal:e})).json()}async function ac(i,t,e){return await(await Ee(`/v1/gamuts/${i.id}/contains`,{method:"POST",body:JSON.stringify({colours:t,distance:!0,position:!0}),signal:e,headers:{"Content-Type":"application/json"}})).json()}async function Bu(i,t,e,n){let s=Object.entries(e).filter(([,a])=>a!==""),r=new URLSearchParams([["position","true"],["distance","true"],...s]);return await(await Ee(`/v1/gamuts/${i.id}/contains?${r}`,{method:"POST",body:t,signal:n,headers:{"Content-Type":"application/octet-stream"}})).json()}var tw=20;async function eg(i,t,e,n){let s=[],r=null,o=null;for(let a=t;;)try{let l=await Bu(i,a,e,n);if(s.length>l.lines.length)break;return{checks:l,refused:s.sort((c,h)=>c.line-h.line)}}catch(l){o??=l,r??=await ew(t);let c=nw(l,r);if(c===null||s.length>=tw)throw o;let{detail:h,remedy:d}=l.problem;s.push({line:c,detail:h,remedy:d}),r[c-1]="",a=new Blob([r.join(`
`)])}throw o}async function ew(i){try{return new TextDecoder("utf-8",{fatal:!0}).decode(await i.arrayBuffer()).split(/\r\n|\r|\n/)}catch{return[]}}function nw(i,t){if(!(i instanceof oe)||i.problem.status!==422)return null;let{line:e,row:n}=i.problem.where??{};return typeof e!="number"||(t[e-1]??"").trim()===""?null:typeof n=="number"||/#|\(|(^|[\s,;])[-+]?\d/.test(t[e-1])?e:null}function lc({edge_width:i,tolerance:t}){let e=n=>n>=1?n.toFixed(1):je(n,2);return`edge: within ${e(i)} of the surface; tolerance ${e(t)}`}async function ng(i,t,e){let n=i.options.space==="CIELAB"?{metric:"CIE 2000"}:{};return await(await Ee(`/v1/gamuts/${i.id}/nearest`,{method:"POST",body:JSON.stringify({colours:t,...n}),signal:e,headers:{"Content-Type":"application/json"}})).json()}var ig=new Set;function cc(i){return i.channels.length>0&&!ig.has(i.id)}async function hc(i,t,e){try{return await(await Ee(`/v1/gamuts/${i.id}/recipes`,{method:"POST",body:JSON.stringify({colours:t}),signal:e,headers:{"Content-Type":"application/json"}})).json()}catch(n){throw n instanceof oe&&n.problem.status===422&&ig.add(i.id),n}}var iw=10,sw=4,uc=class{constructor(t,e){this.page=t;this.table=e;e.onHover=s=>this.mark(s,this.chosen,null),e.onChoose=s=>this.mark(null,s,s),t.view.onDraw.push(()=>this.place());let{canvas:n}=t;n.addEventListener("pointermove",s=>{this.places.length===0||s.buttons!==0||(this.pointer===null&&requestAnimationFrame(()=>this.follow()),this.pointer=s)}),n.addEventListener("pointerleave",()=>{this.pointer=null,this.mark(null,this.chosen,null)}),n.addEventListener("pointerdown",({clientX:s,clientY:r})=>this.down=[s,r]),n.addEventListener("pointerup",({clientX:s,clientY:r})=>{let{down:o}=this;if(this.down=null,o===null||Math.hypot(s-o[0],r-o[1])>sw)return;let a=this.nearest(s,r);a!==null&&this.mark(this.hovered,a===this.chosen?null:a,a)})}page;table;places=[];label=String;hovered=null;chosen=null;down=null;pointer=null;output=L("colour-label");show({colours:t,placement:e,label:n}){this.places=t.map(s=>new P().fromArray(s).applyMatrix4(e)),this.label=n,this.mark(null,null,null)}clear(){this.places=[],this.mark(null,null,null)}follow(){let{pointer:t}=this;if(this.pointer=null,t===null)return;let e=this.nearest(t.clientX,t.clientY);e!==this.hovered&&this.mark(e,this.chosen,e)}mark(t,e,n){this.hovered=t,this.chosen=e,this.table.mark(t,e,n),this.place()}nearest(t,e){let n=this.page.canvas.getBoundingClientRect(),s=null,r=iw;return this.places.forEach((o,a)=>{let[l,c]=this.page.view.stagePlace(o.clone()),h=Math.hypot(l-(t-n.left),c-(e-n.top));h>=r||(r=h,s=a)}),s}place(){let t=this.hovered??this.chosen,e=t===null?void 0:this.places[t];if(this.output.hidden=e===void 0,e===void 0)return;let[n,s]=this.page.view.stagePlace(e.clone()),r=this.label(t);this.output.textContent!==r&&(this.output.textContent=r);let o=this.output.offsetWidth/2+6,{clientWidth:a}=this.page.canvas;this.output.style.left=`${Math.min(Math.max(n,o),Math.max(o,a-o))}px`,this.output.style.top=`${s<60?s+26:s-26}px`}};var co=30,ku=12,Zs=class{constructor(t){this.box=t;let e=tt("thead");e.append(this.head),this.table.append(this.caption,e,this.body),t.addEventListener("scroll",()=>this.draw(),{passive:!0});let n=({target:s})=>{let r=s.closest("tr[data-row]");return r===null?null:Number(r.dataset.row)};this.body.addEventListener("pointerover",s=>this.onHover(n(s))),this.body.addEventListener("pointerleave",()=>this.onHover(null)),this.body.addEventListener("click",s=>{let r=n(s);this.onChoose(r===this.chosen?null:r)}),t.addEventListener("keydown",s=>{let r={ArrowDown:1,ArrowUp:-1}[s.key];if(r===void 0||s.target!==t||this.order.length===0)return;s.preventDefault();let o=this.chosen===null?-1:this.order.indexOf(this.chosen);this.onChoose(this.order[Math.min(this.order.length-1,Math.max(0,o+r))])})}box;order=[];columns=[];sorted=null;head=tt("tr");body=tt("tbody");caption=tt("caption");table=tt("table","",{className:"sorted"});from=-1/0;hovered=null;chosen=null;onHover=()=>{};onChoose=()=>{};mark(t,e,n=null){this.hovered=t,this.chosen=e;let s=n===null?-1:this.order.indexOf(n);if(s>=0){let{box:r,head:o}=this,a=(this.caption.offsetHeight||0)+s*co,l=r.clientHeight-o.offsetHeight-co;(a<r.scrollTop||a>r.scrollTop+l)&&(r.scrollTop=Math.max(0,a-l/2)),this.draw()}for(let r of this.body.rows)this.markRow(r)}markRow(t){let e=Number(t.dataset.row??NaN);t.classList.toggle("hovered",e===this.hovered),e===this.chosen?t.setAttribute("aria-current","true"):t.removeAttribute("aria-current")}show(t,e,n){this.caption.textContent=t,this.columns=e,this.order=Array.from({length:n},(s,r)=>r),this.table.setAttribute("aria-rowcount",String(n+1)),e.every(({title:s})=>s!==this.sorted?.title)&&(this.sorted=null),this.box.replaceChildren(this.table),this.box.hidden=!1,this.sort()}clear(){this.sorted=this.hovered=this.chosen=null,this.order=[],this.box.replaceChildren(),this.box.hidden=!0}sort(){let{sorted:t,order:e}=this;if(e.sort((n,s)=>n-s),t!==null){let{value:n}=this.columns.find(({title:r})=>r===t.title),s=t.ascending?1:-1;e.sort((r,o)=>s*rw(n(r),n(o)))}this.head.replaceChildren(...this.columns.map((n,s)=>this.title(n,s))),this.from=-1/0,this.draw()}title({title:t},e){let n=tt("th");n.scope="col";let s=this.sorted?.title===t,r=s&&this.sorted.ascending;s&&n.setAttribute("aria-sort",r?"ascending":"descending");let o=tt("button",t,{type:"button"}),a=Nd(t);return a!==void 0&&(o.dataset.note=a),s&&o.append(tt("span",r?" ▲":" ▼",{ariaHidden:"true"})),o.addEventListener("click",()=>{this.sorted=s?r?{title:t,ascending:!1}:null:{title:t,ascending:!0},this.sort(),this.head.querySelectorAll("button")[e]?.focus()}),n.append(o),n}draw(){let t=this.order.length,e=Math.max(0,Math.min(t,Math.floor(this.box.scrollTop/co)-ku));if(Math.abs(e-this.from)<ku/2&&(e>0||this.from===0))return;this.from=e;let n=Math.min(t,e+Math.ceil((this.box.clientHeight||400)/co)+3*ku),s=r=>{let o=tt("tr","",{ariaHidden:"true"}),a=tt("td","",{colSpan:this.columns.length});return a.style.height=`${r*co}px`,o.append(a),o};this.body.replaceChildren(...e>0?[s(e)]:[],...this.order.slice(e,n).map((r,o)=>this.row(r,e+o)),...n<t?[s(t-n)]:[])}row(t,e){let n=tt("tr");return n.ariaRowIndex=String(e+2),n.dataset.row=String(t),n.append(...this.columns.map(({cell:s,value:r},o)=>{let a=s?.(t)??String(r(t)),l=tt(o===0?"th":"td");return o===0&&(l.scope="row"),l.append(a),l})),this.markRow(n),n}};function rw(i,t){return typeof i=="number"&&typeof t=="number"?i-t:String(i).localeCompare(String(t),"en",{numeric:!0})}var sg=["space","scale","edge","columns"],ow=1500,dc=class{constructor(t){this.page=t;this.links=new uc(t,this.table),t.on(["slots"],()=>this.show(t.shown[0]?.gamut??null)),t.on(["theme"],()=>{this.answer!==null&&(this.erase(),this.draw(this.answer))}),t.kept.set("list",()=>this.answer&&{...this.answer,gamut:this.gamut.id}),t.address.add({read:e=>{this.text.value=e.get("colours")??this.text.value;for(let n of sg){let s=e.get(`colours-${n}`);s!==null&&(L(`colours-${n}`).value=s)}this.summarise(),this.wanted=this.text.value.trim()!=="",this.wanted&&sr("colours-part")},write:()=>{let e=this.text.value.trim();if(e===""||e.length>ow)return[];let{space:n,columns:s,table_scale:r,edge_width:o}=this.stated(),a={space:n,scale:r,edge:o,columns:s};return[["colours",e],...sg.map(l=>[`colours-${l}`,a[l]||null])]}}),L("check").addEventListener("click",()=>{t.complain(null),this.check()}),L("colours-clear").addEventListener("click",()=>{this.text.value="",this.file=null,this.check()}),L("colours-csv").addEventListener("click",()=>this.download()),L("colours-file").addEventListener("change",e=>{let n=e.target,[s]=n.files??[];s!==void 0&&(n.value="",this.take(s))}),L("colours-open").addEventListener("click",()=>L("colours-file").click()),this.text.addEventListener("input",()=>{this.file=null}),this.reading.addEventListener("change",()=>{this.summarise(),this.list!==null&&this.check()}),this.summarise()}page;onChange=()=>{};group=null;asking=new be;gamut=null;answer=null;wanted=!1;file=null;table=new Zs(L("colours-table"));links;text=L("colours");reading=L("colours-reading");get against(){return this.gamut?.name??null}take(t){ec("colours-part"),this.file=t,this.text.value="",this.page.complain(null),this.check()}show(t){if(t?.id!==this.gamut?.id){if(this.gamut=t,qt!==null){this.restore(qt.state?.list);return}L("check").disabled=t===null,(this.answer!==null||this.asking.isAsking||this.wanted)&&this.check()}}restore(t){this.clear();let e=t!=null&&t.gamut===this.gamut?.id;L("colours-part").hidden=!e,e&&(sr("colours-part"),this.answer=t,this.draw(t),this.tabulate(t))}get list(){return this.file??(this.text.value.trim()===""?null:new Blob([this.text.value]))}get colours(){return this.answer===null?null:this.list}stated(){let t=e=>L(`colours-${e}`).value.trim();return{space:t("space"),columns:t("columns"),table_scale:t("scale"),edge_width:t("edge")}}summarise(){let{space:t,columns:e,table_scale:n,edge_width:s}=this.stated(),r=[t,n&&`white at ${n}`,e&&`columns ${e}`,s&&`edge ${s}`].filter(o=>o!=="");L("colours-reading-summary").textContent=r.join(", ")||"the table says"}async check(){this.clear(),this.page.address.save();let{gamut:t,list:e}=this;if(this.wanted=t===null&&e!==null,t===null||e===null)return;for(let s of["scale","edge"]){let r=L(`colours-${s}`);if(!r.checkValidity()){this.reading.open=!0,r.reportValidity();return}}let n=this.stated();L("colours-note").textContent="Checking …",await this.asking.ask(async s=>{let{checks:r,refused:o}=await eg(t,e,n,s);return{checks:r,near:await ng(t,r.colours,s),made:null,refused:o}},s=>{this.answer=s,this.draw(s),this.tabulate(s),this.onChange(),this.addRecipes(t,s)},s=>this.refuse(s))}async addRecipes(t,e){if(!cc(t))return;let{checks:n,near:s}=e,r=L("colours-recipes");r.textContent="The recipes of the colours are on their way.";let o=n.colours.map((a,l)=>n.inside[l]?a:s.point[l]);await this.asking.ask(a=>hc(t,o,a),a=>{r.textContent="",e.made=a,this.tabulate(e)},a=>{let[,...l]=si(a);r.textContent=["There are no recipes.",...l.map(c=>c.textContent)].join(" ")})}refuse(t){if(t instanceof oe&&[401,403].includes(t.problem.status)){this.page.complain(t);return}t instanceof oe&&t.problem.code==="too-many-rows"&&(t.problem.remedy="Check fewer colours at once. The command gamut query takes files of any length."),L("colours-note").textContent="";let[,...e]=si(t),n=this.file===null?"The list is refused":`${this.file.name} is refused`;L("colours-problem").replaceChildren(tt("strong",n),...e),L("colours-problem").hidden=!1,this.reading.open=!0}draw({checks:t,near:e}){let{colours:n,inside:s,position:r}=t,o=n.flat(),a=sn(this.gamut).linear(Float32Array.from(o),ge),l=n.flatMap((_,M)=>s[M]?[]:[..._,...e.point[M]]),c=e.point.flatMap((_,M)=>s[M]?[]:_),h=n.flatMap((_,M)=>r[M]==="outside"?_:[]),d=getComputedStyle(document.body).color,u=getComputedStyle(L("problem")).borderTopColor,f=_=>new he().setAttribute("position",new Qt(_,3)),g=f(o).setAttribute("color",new Qt(a,3)),x=_=>({size:_,sizeAttenuation:!1,depthTest:!1});this.group=new Ne;let p=[new Rn(f(l),new mn({color:d,depthTest:!1})),new In(f(c),new Pn({color:d,...x(4)})),new In(f(h),new Pn({color:u,...x(15)})),new In(g,new Pn({color:d,...x(11)})),new In(g,new Pn({vertexColors:!0,...x(8)}))];p.forEach((_,M)=>{_.renderOrder=3+M,_.frustumCulled=!1}),this.group.add(...p);let m=yn(Se(this.gamut));this.group.applyMatrix4(m),this.links.show({colours:n,placement:m,label:_=>`${this.label(t,_)}: ${r[_]}`}),this.page.view.scene.add(this.group),this.page.view.draw()}label({labels:t,lines:e,colours:n},s){return t[s]===`line ${e[s]}`?rg(n[s]):t[s]}tabulate(t){let{checks:e,near:n,made:s}=t,{colours:r,position:o}=e,a=c=>`${o.filter(h=>h===c).length} ${c}`,l=[this.file===null?"":`${this.file.name}: `,`${r.length} ${r.length===1?"colour":"colours"}: ${a("inside")}, ${a("edge")}, ${a("outside")} (${lc(e)}).`,` ${e.reading}`];L("colours-note").textContent=l.join(""),this.tell(t.refused??[]),L("colours-warnings").replaceChildren(...cs([e,n,s].flatMap(c=>c?.warnings??[])).map(c=>tt("p",c,{className:"warning"}))),this.table.show(`Colours in ${this.gamut.name}`,this.columns(t),r.length),L("colours-csv").disabled=!1}tell(t){let e=L("colours-refused");e.hidden=t.length===0;let n=t.length===1?"One line is refused":`${t.length} lines are refused`,s=new Set(t.map(({remedy:r})=>r));e.replaceChildren(tt("strong",n),...t.map(({line:r,detail:o})=>tt("p",`Line ${r}: ${o}`)),...[...s].map(r=>tt("p",r)))}columns({checks:t,near:e,made:n}){let{colours:s,inside:r,position:o}=t,{channels:a}=this.gamut,l=sn(this.gamut).linear(Float32Array.from(s.flat()),ge),c=m=>n?.device[m]??(r[m]?void 0:e.device?.[m]),h=m=>r[m]?0:e.delta_e_2000[m],d=m=>{let _=tt("span",this.label(t,m),{title:this.label(t,m)}),M=tt("span","",{className:"spot"});return M.style.backgroundColor=Jn(l.subarray(3*m,3*m+3)),_.prepend(M),_},u=n!==null||e.device!==void 0,f=m=>c(m)===void 0?"":Fu(a,c(m)),[g,x]=[n?.black_least,n?.black_most],p=m=>t.distance[m];return[{title:"Colour",value:m=>this.label(t,m),cell:d},{title:"Where",value:p,cell:m=>tt("span",o[m],{className:`where-${o[m]}`})},{title:"ΔE00",value:h,cell:m=>h(m).toFixed(2)},...u?[{title:`${n?"Recipe":a.join(" ")}, ${js}`,value:f}]:[],...g&&x?[{title:`Possible ${oc(a)}, %`,value:m=>x[m]??-1,cell:m=>rc(n,m)??""}]:[],...n?[{title:"Recipe ΔE00",value:m=>n.delta_e_2000[m],cell:m=>n.delta_e_2000[m].toFixed(2)}]:[],{title:"Euclidean distance",value:p,cell:m=>p(m).toFixed(2).replace("-","−")},{title:"Nearest",value:m=>r[m]?"itself":rg(e.point[m])}]}download(){if(this.answer===null)return;let{checks:t,near:e,made:n}=this.answer,{colours:s,position:r}=t,o=u=>/[",\r\n]/.test(u)?`"${u.replaceAll('"','""')}"`:u,a=n||e.device?this.gamut.channels:[],l=["c1","c2","c3"],c=["name",...l,"position","inside","Euclidean distance","ΔE00",...l.map(u=>`nearest ${u}`),...a.map(u=>o(`${u} ${js}`))];n&&c.push("recipe ΔE00"),n?.black_least&&c.push(`least black ${js}`,`most black ${js}`);let h=s.map((u,f)=>{let g=t.inside[f],x=n?.device[f]??(g?void 0:e.device?.[f]),p=x===void 0?a.map(()=>""):Uu(x),m=g?0:e.delta_e_2000[f],_=[o(this.label(t,f)),...u,r[f],g,t.distance[f],m,...g?u:e.point[f],...p];return n&&_.push(n.delta_e_2000[f]),n?.black_least&&_.push(...[n.black_least[f],n.black_most[f]].map(M=>M==null?"":Uu([M])[0])),_}),d=new Blob([[c,...h].map(u=>u.join(",")).join(`
`),`
`],{type:"text/csv"});Zi(d,`colours in ${this.gamut.name}.csv`)}erase(){this.group?.traverse(t=>{!(t instanceof In)&&!(t instanceof Rn)||(t.geometry.dispose(),t.material.dispose())}),this.group?.removeFromParent(),this.group=null,this.page.view.draw()}clear(){this.asking.end(),this.erase(),this.answer=null,this.links.clear(),this.tell([]),L("colours-warnings").replaceChildren(),L("colours-recipes").textContent="",L("colours-problem").hidden=!0,L("colours-problem").replaceChildren(),this.table.clear(),L("colours-note").textContent="",L("colours-csv").disabled=!0,this.onChange()}};function rg(i){return i.map(t=>Number(t.toFixed(2)).toString().replace("-","−")).join(" ")}function Vi(i,t="--box"){let e=getComputedStyle(i),n=document.createElement("span");i.append(n);let s=o=>(n.style.color=`var(${o})`,getComputedStyle(n).color),r={text:e.color,soft:s("--soft"),line:s("--line"),back:s(t)};return n.remove(),r}function zu(i,t){let{documentElement:e}=new DOMParser().parseFromString(t,"image/svg+xml");i.replaceChildren(document.importNode(e,!0))}function og(i,t){let e=0,n=()=>{e=Math.floor(i.clientWidth),e>0&&zu(i,t(e))};return new ResizeObserver(()=>Math.floor(i.clientWidth)!==e&&n()).observe(i),n}async function aw(i,t){let e=new Image;e.src=URL.createObjectURL(new Blob([i],{type:"image/svg+xml"}));try{await e.decode();let n=new OffscreenCanvas(Math.round(t*e.width),Math.round(t*e.height));return n.getContext("2d").drawImage(e,0,0,n.width,n.height),await n.convertToBlob()}finally{URL.revokeObjectURL(e.src)}}async function fc(i,t,e,n=2){e==="svg"?Zi(new Blob([i],{type:"image/svg+xml"}),`${t}.svg`):Zi(await aw(i,n),`${t}.png`)}var lw=.65,ag=36;function cw(i,t,e){let n=lg(i),s=t.flatMap(o=>{let a=o*Math.PI/180;return[lw*n,e*Math.cos(a),e*Math.sin(a)]}),r=i.linear(Float32Array.from(s),"srgb");return t.map((o,a)=>Jn(r.subarray(3*a,3*a+3),"srgb"))}function lg(i){let[t,e]=[0,1e3];for(let n=0;n<40;n++){let s=(t+e)/2;i.toXyz(Float32Array.of(s,0,0))[1]<1?t=s:e=s}return t}function cg(i,t,e,{size:n,theme:s,space:r,unit:o="cubic units"}){let[a,l]=[io(i,ag),io(t,ag)],c=e.hue_from.length,h=(v,w)=>Math.max(0,v[w]-e.intersection[w]),d=Array.from({length:c},(v,w)=>[h(e.volume_a,w),h(e.volume_b,w)]),u=Math.max(1e-12,...d.flat()),f=3*Math.floor(Math.log10(u)/3),g=f>=3||f<=-3?10**f:1,x=Math.max(...d.map(([v])=>v),.15*u)/g,p=Math.max(...d.map(([,v])=>v),.15*u)/g,m=no(x+p,5),_=[];for(let v=-Math.floor(p/m);v*m<=x;v++)_.push({value:v*m,text:je(Math.abs(v*m))});let M=g===1?"":g===1e3?"thousand ":g===1e6?"million ":`10^${je(f)}^ `,y=new Gi({size:n,theme:s,title:"Volume of only one gamut, by hue",caption:`Above the line: only ${a} has it. Below: only ${l}.`,x:{range:[0,360],label:"Hue",ticks:[0,60,120,180,240,300,360].map(v=>({value:v,text:`${v}°`}))},y:{range:[-1.12*p,1.12*x],label:`Volume, ${M}${o}`,ticks:_}}),T=e.hue_from.map((v,w)=>(v+e.hue_to[w])/2),E=cw(r,T,.5*lg(r));return d.forEach(([v,w],F)=>{let[D,N]=[e.hue_from[F],e.hue_to[F]],O=C=>[[D,0],[N,0],[N,C],[D,C]],V={fill:E[F],stroke:s.text,width:.6};v>0&&y.polygon(O(v/g),V),w>0&&y.polygon(O(-w/g),V)}),y.line([[0,0],[360,0]],{stroke:s.text,width:1.2}),y.text([6,1.12*x],`only ${a}`,[0,12]),y.text([6,-1.12*p],`only ${l}`,[0,-10]),y.svg()}var hw=280,pc=class{constructor(t){this.page=t;this.redraw=og(L("comparison-chart"),e=>(this.chart=this.sectors(e),this.chart)),t.address.add({read:e=>{this.highlight.checked=e.get("outside")==="on"},write:()=>[["outside",this.highlight.checked?"on":null]]}),t.kept.set("comparison",()=>this.comparison),t.on(["slots"],()=>{let[e,n]=[t.at("a"),t.at("b")];this.show(e!==null&&n!==null?{a:e,b:n}:null)}),t.on(["looks"],()=>this.mark()),t.on(["theme"],()=>{this.tint(),this.comparison!==null&&this.redraw()}),this.highlight.addEventListener("change",()=>{this.highlight.checked&&(t.setOpacity("a",1),t.setVisible("a",!0)),this.mark(),t.address.save()});for(let e of["svg","png"])L(`comparison-${e}`).addEventListener("click",()=>{let{a:n,b:s}=this.pair;fc(this.chart,`${n.gamut.name} and ${s.gamut.name} by hue`,e,3)})}page;pair=null;comparison=null;coverage=null;asking=new be;chart="";highlight=L("highlight");redraw;show(t){let e=s=>s&&`${s.a.gamut.id} ${s.b.gamut.id}`,n=e(t)!==e(this.pair)||t?.a.layer!==this.pair?.a.layer;this.pair=t,L("comparison-more").hidden=t===null,this.mark(),n&&(this.asking.end(),this.comparison=null,L("coverage").replaceChildren(),L("comparison-figure").hidden=!0,t!==null?this.compare(t):L("answer").replaceChildren(tt("p","Choose a second gamut to compare it with the first.",{className:"note"})))}async compare({a:t,b:e}){let n=qt?.state?.comparison,s=r=>L("coverage").replaceChildren(tt("p",r,{className:"note"}));this.answer(null,{a:t,b:e}),qt===null&&s("Comparing …"),await this.asking.ask(async r=>{let o=await Dm(t.gamut.id,e.gamut.id);return o!==void 0&&!r.aborted&&this.answer(o,{a:t,b:e}),qt!==null?n:tg(t.gamut.id,e.gamut.id,r)},r=>r&&this.tell(r,{a:t,b:e}),r=>{let o=r instanceof oe?`${r.problem.detail} ${Hc(r.problem)}`:String(r);s(o),L("answer").querySelector(".pending")?.replaceChildren(o)})}get bars(){let{coverage:t,pair:e}=this;return e===null||t===null||!L("comparison").open?[]:hg(t,e)}answer(t,{a:e,b:n}){this.coverage=t;let s=[e,n].map(({gamut:o})=>`${o.name} ${Ys(o)}`).join(", "),r=t===null&&qt===null;L("answer").replaceChildren(...t===null?[]:hg(t,{a:e,b:n}).map(uw),...r?[tt("p","Comparing …",{className:"note pending"})]:[],tt("p",`Volumes: ${s} ${Si(e.gamut)}.`,{className:"note"}),...t===null?[]:[tt("p",fw(t.summary,[e.gamut.name,n.gamut.name]))]),this.tint()}tint(){for(let t of L("answer").querySelectorAll("[data-slot]"))t.style.backgroundColor=Ze(t.dataset.slot,this.page.isDark)}tell(t,{a:e,b:n}){let s=[e.gamut.name,n.gamut.name];this.answer(t,{a:e,b:n});let r=tt("ul","",{className:"sentences"});for(let c of t.summary){let h=tt("li");h.append(...Eo(ug(c,s))),r.append(h)}let o=wo(pw(t,s)),a=t.warnings.map(c=>tt("p",c,{className:"warning"}));L("coverage").replaceChildren(r,o,...a),this.comparison=t;let l=Se(e.gamut)[0]!=="X";L("comparison-figure").hidden=!l,l&&this.redraw()}sectors(t){let{pair:e,comparison:n}=this;if(e===null||n===null)return"<svg xmlns='http://www.w3.org/2000/svg'/>";let{a:s,b:r}=e;return cg(s.gamut.name,r.gamut.name,n.sectors,{size:{width:t,height:hw},theme:Vi(L("comparison-chart"),"--back"),space:sn(s.gamut),unit:Si(s.gamut)})}mark(){let{pair:t,page:e}=this,n=t!==null&&this.highlight.checked;for(let{layer:s}of e.shown)s.setGrey(n&&s===t.a.layer),s.setCounted(n&&s===t.b.layer);e.view.draw()}};function hg(i,{a:t,b:e}){let n=(s,r,o)=>({slot:s.slot,name:s.gamut.name,other:r.gamut.name,share:o,text:dw(o)});return[n(t,e,i.a_covers_b),n(e,t,i.b_covers_a)]}function uw({slot:i,name:t,other:e,share:n,text:s}){let r=tt("div","",{className:"coverage-bar"}),o=tt("p",`${t} covers `);o.append(tt("strong",s),` of ${e}`);let a=tt("div"),l=tt("div");return l.dataset.slot=i,l.style.width=`${100*n}%`,a.append(l),r.append(o,a),r}function dw(i){return i>0&&i<.005?"under 1 %":i>=.995&&i<.99995?"over 99 %":`${Math.round(100*i)} %`}function fw(i,t){let e=i.filter(n=>/^(A|B|A and B) reach(es)? /.test(n)).map(n=>ug(n.replace(/(: by up to .*)?\.$/,"").replaceAll(/\(hue (\d+)° to (\d+)°\)/g,"($1–$2°)"),t));return e.length===0?"":`${e.join("; ")}.`}function ug(i,[t,e]){return i.replaceAll(/\b[AB]\b/g,n=>n==="A"?t:e)}function pw(i,[t,e]){let n=o=>`${(100*o).toFixed(2)} %`,s=o=>o.map(a=>Number(a.toFixed(a<5&&a>-5?3:1))).join(" ").replaceAll("-","−"),r=[[`${t} covers`,`${n(i.a_covers_b)} of ${e}`,"The volume that both have, relative to the volume of the covered gamut."],[`${e} covers`,`${n(i.b_covers_a)} of ${t}`]];for(let[o,a,l]of[[i.lost_a,t,e],[i.lost_b,e,t]])o!=null&&r.push([`${a} loses in ${l}`,`ΔE00 ${o.mean.toFixed(2)} on average, ${o.percentile_95.toFixed(1)} at the 95th percentile`,"Colour difference CIEDE2000 between the surface and the nearest colours of the other gamut; 0 where it has them."]);if(r.push(["White points",`${t} ${s(i.white_a)}; ${e} ${s(i.white_b)}`,"Lightest colours."],["Black points",`${t} ${s(i.black_a)}; ${e} ${s(i.black_b)}`,"Darkest colours."],["In common",Number(i.intersection.toPrecision(6)).toLocaleString("en"),"Volume that both have, in cubic units of the space."],["Jaccard index",i.jaccard.toFixed(4),"The volume that both have, relative to the volume that at least one has; 1 for equal gamuts."]),i.chromaticity!==null)for(let[o,a]of[["x, y",i.chromaticity.xy],["u′, v′",i.chromaticity.uv]])r.push([`${o}: ${t} covers`,`${n(a.a_covers_b)} of ${e}; area ${n(a.area_ratio)}`,"Areas in the chromaticity diagram, without lightness."],[`${o}: ${e} covers`,`${n(a.b_covers_a)} of ${t}`]);return r}function fg(i){let t=L("projection"),e=L("axes"),n=L("edges");i.address.add({read:s=>{t.value=s.get("projection")==="orthographic"?"orthographic":"perspective",e.checked=s.get("axes")!=="off",i.view.setProjection(t.value),i.hasAxes=e.checked,i.hasEdges||=s.get("edges")==="on",dg(s.get("theme")??void 0)},write:()=>[["projection",i.view.projection],["axes",i.hasAxes?null:"off"],["edges",i.hasEdges?"on":null],["theme",document.documentElement.dataset.theme??null]]}),t.addEventListener("change",()=>i.view.setProjection(t.value)),e.addEventListener("change",()=>i.setAxes(e.checked)),n.addEventListener("change",()=>i.setEdges(n.checked)),i.on(["slots","looks"],()=>n.checked=i.hasEdges),L("theme").addEventListener("click",()=>{let s={undefined:"light",light:"dark",dark:void 0}[String(document.documentElement.dataset.theme)];dg(s),i.emit("theme")})}function dg(i){let{dataset:t}=document.documentElement;i==="light"||i==="dark"?t.theme=i:delete t.theme;let e=L("theme");e.textContent={light:"Light",dark:"Dark"}[t.theme??""]??"Auto",e.setAttribute("aria-label",`Colour scheme: ${e.textContent}`)}function gg(i){let t=()=>{let e=i.shown.flatMap(({gamut:n})=>gw(n));L("facts").replaceChildren(...e.length>0?e:[tt("p","No gamut is shown.",{className:"note"})])};i.on(["slots"],()=>{t(),pg(i)}),i.on(["level"],()=>pg(i))}function pg({shown:i,canvas:t}){let e=i.map(({gamut:n,layer:s})=>`${n.name}, ${s.level?.triangles??0} triangles`);t.setAttribute("aria-label",e.length===0?"No gamut is shown":e.join("; ")),document.title=[...i.map(({gamut:n})=>n.name),"Gamut viewer"].join(" – ")}function mw({volume:i,volumes:t={},...e}){let n={own:"Volume",relative:"Volume, relative",absolute:"Volume, absolute"},s=o=>`${mg(o,6)} ${Si(e)}`,r=Object.entries(n).flatMap(([o,a])=>{let l=t[o];return l?[[a,`${s(l.volume)}, ${mg(l.times_srgb,3)} × sRGB`,hs.volume]]:[]});return r.length>0?r:[["Volume",s(i)]]}function mg(i,t){return i.toLocaleString("en",{maximumSignificantDigits:t})}function gw(i){let t=cs(i.provenance.warnings);return[tt("h3",i.name),wo([...Jm(i),...mw(i),["Full boundary",`${i.counts.triangles.toLocaleString("en")} triangles`],...i.options.boundary==="auto"?[]:[["Method",i.options.boundary]],...i.channels.length>0?[["Channels",i.channels.join(" ")]]:[]]),...t.map(e=>tt("p",e,{className:"warning"}))]}var vw=150,mc=class{constructor(t,e,n,s){this.choose=n;this.fail=s;let r=`chooser-${t.dataset.role}`,o=document.createElement("label");o.htmlFor=r,o.textContent=e,this.input=document.createElement("input"),Object.assign(this.input,{id:r,type:"text",autocomplete:"off",spellcheck:!1}),this.input.placeholder="Choose …",this.list=document.createElement("ul"),this.list.id=`${r}-list`,this.list.hidden=!0,this.set(this.list,{role:"listbox","aria-label":e}),this.set(this.input,{role:"combobox","aria-expanded":"false","aria-controls":this.list.id,"aria-autocomplete":"list"}),this.clear=document.createElement("button"),Object.assign(this.clear,{type:"button",className:"clear",textContent:"×",hidden:!0}),this.clear.setAttribute("aria-label",`Remove ${e.toLowerCase()}`);let a=document.createElement("div");a.className="field",a.append(this.input,this.clear),t.append(o,a,this.list),this.input.addEventListener("focus",()=>this.input.select()),this.input.addEventListener("click",()=>this.open()),this.input.addEventListener("input",()=>{this.isSearch=this.clear.hidden=!0,this.isFresh=!1,this.asking.end(),clearTimeout(this.typing),this.typing=setTimeout(()=>this.open(),vw)}),this.input.addEventListener("keydown",l=>this.key(l)),this.input.addEventListener("blur",()=>{this.close(),this.state(this.name)}),this.list.addEventListener("pointerdown",l=>l.preventDefault()),this.list.addEventListener("click",l=>{let c=l.target.closest("[data-place]");c!==null&&this.take(Number(c.dataset.place))}),this.clear.addEventListener("click",()=>{this.state(""),this.choose(null),this.input.focus()})}choose;fail;input;list;clear;entries=[];active=-1;typing=0;name="";isSearch=!1;isFresh=!1;asking=new be;show(t){this.isSearch?this.name=t:this.state(t)}state(t){this.isSearch=!1,this.name=this.input.value=t,this.clear.hidden=t===""}async open(t=!1){let e=this.isSearch?this.input.value.trim():"";await this.asking.ask(n=>Ad(e,n),n=>{document.activeElement===this.input&&(this.fill(n),t&&this.take(0))},this.fail)}fill(t){this.entries=t,this.isFresh=!0,this.active=-1;let e=t.map((n,s)=>{let r=this.item(n.name,{role:"option",id:`${this.list.id}-${s}`,"aria-selected":"false"});r.dataset.place=String(s);let o=document.createElement("small");return o.textContent=n.detail,r.append(o),r});e.length===0&&e.push(this.item("No gamut has this name.",{role:"presentation"})),this.list.replaceChildren(...e),this.list.hidden=!1;for(let n of[this.list,this.input])n.scrollIntoView({block:"nearest"});this.input.setAttribute("aria-expanded","true")}item(t,e){let n=document.createElement("li");return n.textContent=t,this.set(n,e),n}key(t){t.key==="ArrowDown"||t.key==="ArrowUp"?(t.preventDefault(),this.list.hidden?this.open():this.activate(this.active+(t.key==="ArrowDown"?1:-1))):t.key==="Enter"&&this.isSearch&&!this.isFresh&&this.active<0?(t.preventDefault(),clearTimeout(this.typing),this.input.value.trim()!==""&&this.open(!0)):t.key==="Enter"&&!this.list.hidden?(t.preventDefault(),this.take(Math.max(0,this.active))):t.key==="Escape"&&this.close()}activate(t){let e=this.entries.length;if(e!==0){this.active=(t+e)%e;for(let n of this.list.querySelectorAll("[data-place]")){let s=Number(n.dataset.place)===this.active;n.setAttribute("aria-selected",String(s)),s&&(n.scrollIntoView({block:"nearest"}),this.input.setAttribute("aria-activedescendant",n.id))}}}take(t){let e=this.entries[t];e!==void 0&&(this.state(e.name),this.close(),this.choose(e))}close(){clearTimeout(this.typing),this.asking.end(),this.list.hidden=!0,this.input.setAttribute("aria-expanded","false"),this.input.removeAttribute("aria-activedescendant")}set(t,e){for(let[n,s]of Object.entries(e))t.setAttribute(n,s)}};var vg={a:"First gamut",b:"Second gamut",c:"Third gamut",d:"Fourth gamut",e:"Fifth gamut",f:"Sixth gamut"},xw='<svg viewBox="0 0 24 24" width="20" height="20" aria-hidden="true" fill="none" stroke="currentColor" stroke-width="1.8"><path d="M2 12Q12 0 22 12Q12 24 2 12Z"/><circle cx="12" cy="12" r="3.2"/><path class="closed" d="M4 21L20 3"/></svg>',_w=2,gc=class{constructor(t){this.page=t;this.rows=new Map(ue.map(e=>[e,this.row(e)])),L("gamut-list").append(...[...this.rows.values()].map(({box:e})=>e)),L("add").addEventListener("click",()=>{this.count=Math.min(ue.length,this.count+1),this.refresh(),L(`chooser-${ue[this.count-1]}`).focus()}),t.on(["slots","looks","requests","theme"],()=>this.refresh()),this.refresh()}page;rows;count=_w;row(t){let e=tt("div","",{className:"gamut-row"}),n=tt("div","",{className:"chooser online"});e.dataset.slot=n.dataset.role=t;let s=new mc(n,vg[t],d=>{this.page.show(t,d?.key??null)},d=>this.page.complain(d)),r=tt("span","",{className:"tint"}),o=tt("span","",{className:"saved-name",hidden:qt===null});(qt===null?n.querySelector("label"):o).prepend(r);let a=vg[t].toLowerCase(),l=tt("button","",{id:`eye-${t}`,type:"button",className:"eye",innerHTML:xw});l.addEventListener("click",()=>this.page.setVisible(t,!this.page.lookOf(t).isVisible)),l.setAttribute("aria-label",`Show the ${a}`);let c=tt("input","",{id:`opacity-${t}`,type:"range",min:"0.05",max:"1",step:"0.05",title:"Opacity"});c.setAttribute("aria-label",`Opacity of the ${a}`),c.addEventListener("input",()=>this.page.setOpacity(t,c.valueAsNumber));let h=tt("span","",{className:"volume"});return e.append(n,o,h,l,c,tt("div","",{className:"waiting"})),{box:e,chooser:s,eye:l,opacity:c,mark:r,name:o,volume:h}}refresh(){let{page:t}=this,e=n=>t.at(n)!==null||this.rows.get(n).box.querySelector(".work")!==null;this.count=Math.max(this.count,ue.findLastIndex(e)+1),ue.forEach((n,s)=>{let{box:r,chooser:o,eye:a,opacity:l,mark:c,name:h,volume:d}=this.rows.get(n),u=t.at(n);r.hidden=s>=this.count||qt!==null&&u===null;let f=t.lookOf(n);a.setAttribute("aria-pressed",String(f.isVisible)),l.value=String(f.opacity),a.disabled=l.disabled=u===null,c.style.backgroundColor=Ze(n,t.isDark),d.replaceChildren(...u===null?[]:[Ys(u.gamut),tt("span",` ${Si(u.gamut)}`,{className:"unit"})]),qt!==null&&h.replaceChildren(c,u?.gamut.name??""),o.show(u?.gamut.name??"")}),L("add").hidden=this.count>=ue.length,L("legend").replaceChildren(...t.shown.filter(({slot:n})=>t.lookOf(n).isVisible).map(({slot:n,gamut:s})=>{let r=tt("span","",{className:"tint"});r.style.backgroundColor=Ze(n,t.isDark);let o=tt("p",s.name,{title:s.name});return o.prepend(r),o}))}};var Hu=1e3,ho=4;function xg(i){let t=L("slider"),e=L("triangles");t.addEventListener("input",()=>i.setTriangles(yw(Number(t.value),i.finest))),e.addEventListener("change",()=>{e.value!==""&&i.setTriangles(Number(e.value)),e.value=String(i.triangles)});let n=()=>{let{finest:s,shown:r}=i;t.disabled=e.disabled=r.length===0;let o=Math.min(i.triangles,s);t.value=String(bw(o,s)),t.setAttribute("aria-valuetext",`${o} triangles`),e.max=String(s),document.activeElement!==e&&(e.value=String(o)),L("level-note").replaceChildren(...r.map(({gamut:a,layer:l,isPart:c})=>tt("span",Sw(a,l.level?.triangles??0,c?Math.min(o,l.available):o))))};i.on(["slots","level"],n)}function yw(i,t){let e=ho*(t/ho)**(i/Hu);return Math.min(t,2*Math.round(e/2))}function bw(i,t){return t<=ho?Hu:Math.round(Hu*Math.log(i/ho)/Math.log(t/ho))}function Sw(i,t,e){let n=`${i.name}: ${t.toLocaleString("en")}`;if(t<Math.min(e,i.counts.triangles))return`${n}, loading`;if(t===i.counts.triangles)return`${n}, the full boundary`;let s=i.levels.findLast(a=>a.triangles<=t);if(s===void 0)return n;let r=i.options.space==="CIELAB"?" ΔE*ab":"",o=s.triangles===t?"within":"within about";return`${n}, ${o} ${je(s.distance_bound,2)}${r}`}var vc=class{constructor(t){this.page=t;this.box.addEventListener("change",()=>{this.refresh()}),t.on(["slots"],()=>{let e=t.at("a")?.gamut??null;e?.id!==this.gamut?.id&&(this.gamut=e,this.offerPatches(e),this.refresh())}),t.on(["theme"],()=>{this.refresh()})}page;box=L("mark-patches");asking=new be;group=null;gamut=null;async offerPatches(t){let{box:e}=this,n=t?.provenance.patches!==void 0&&t.options.source===void 0;if(e.disabled=t===null||!n||!this.page.files.has(t.id),t===null||!e.disabled||t.channels.length===0)return;let s=await ao(this.page.at("a")?.key??"");t===this.gamut&&s?.file!=null&&(e.disabled=!1,this.refresh())}async refresh(){this.asking.end(),this.remove();let{box:t,gamut:e,page:n}=this;e===null||!t.checked||t.disabled||await this.asking.ask(s=>this.patches(e,s),({colours:s,position:r})=>{let o=new Ne;o.add(...this.points(e,s,r));for(let a of o.children)Object.assign(a,{renderOrder:3,frustumCulled:!1});o.applyMatrix4(yn(Se(e))),n.view.scene.add(o),this.group=o,this.note(ww(r)),n.view.draw()},s=>{t.checked=!1,this.note(s instanceof oe?s.problem.detail:String(s))})}async patches(t,e){let n={space:"",columns:"",table_scale:"",edge_width:""},s=this.page.files.get(t.id)??await this.page.sourceOf("a"),r=await Bu(t,s,n,e),o=Mw(t,r.colours),{position:a}=o===r.colours?r:await ac(t,o,e);return{colours:o,position:a}}points(t,e,n){let s=e.filter((c,h)=>n[h]==="outside"),r=new Pn({color:getComputedStyle(L("problem")).borderTopColor,size:9,sizeAttenuation:!1}),o=_g(e),a=sn(t).linear(Float32Array.from(e.flat()),ge);o.setAttribute("color",new Qt(a,3));let l=new Pn({vertexColors:!0,size:5,sizeAttenuation:!1});return[new In(_g(s),r),new In(o,l)]}note(t){L("marks-note").textContent=t}remove(){if(this.note(""),this.group!==null){for(let t of this.group.children)t.geometry.dispose(),t.material.dispose();this.group.removeFromParent(),this.group=null,this.page.view.draw()}}};function _g(i){return new he().setAttribute("position",new Qt(i.flat(),3))}function Mw(i,t){let{intent:e,medium:n,white_lab:s}=i.provenance;if(e!=="relative"||n!=="reflective"||!s||i.options.space!=="CIELAB")return t;let r=hm(Float32Array.from(t.flat()),s);return t.map((o,a)=>[...r.subarray(3*a,3*a+3)])}function ww(i){let t=i.filter(e=>e==="outside").length;return`${i.length.toLocaleString("en")} patches of the file, ${t.toLocaleString("en")} of them outside of this gamut.`}var Ew=3,xc=class{constructor(t,e){this.page=t;this.list=e;qt===null&&(e.onChange=()=>this.update(),t.on(["slots"],()=>this.ids.join()!==this.asked&&this.update()))}page;list;asking=new be;section=L("match-section");table=new Zs(L("match-table"));asked="";get ids(){return this.page.shown.map(({gamut:t})=>t.id)}update(){let{ids:t,list:e}=this;this.asking.end(),this.table.clear(),this.asked=t.join();let{colours:n}=e;this.section.hidden=t.length<Ew||n===null,L("match-shares").replaceChildren(),L("match-note").replaceChildren(),!(this.section.hidden||n===null)&&this.asking.ask(s=>Aw(t,n,e.stated(),s),s=>this.show(s),s=>L("match-note").replaceChildren(...si(s)))}show({colours:t,gamuts:e,together:n,warnings:s}){let r=t.name.length;L("match-shares").replaceChildren(...e.flatMap(({name:h,share:d,mean_delta_e_2000:u})=>[tt("dt",h),tt("dd",`prints ${Math.round(d*r)} of ${r} (${(100*d).toFixed(0)} %), mean ΔE00 ${u.toFixed(2)}`)]));let o=n.map(({gamuts:h,printed:d,exact:u})=>`${Tw(h)} together print ${d}${u?"":" or more"}.`);L("match-note").replaceChildren(tt("p",o.join(" "),{className:"note"}),...cs(s).map(h=>tt("p",h,{className:"warning"})));let a=sn(this.page.shown[0].gamut).linear(Float32Array.from(t.point.flat()),ge),c=[{title:"Colour",value:h=>t.name[h],cell:h=>{let d=tt("span",t.name[h],{title:t.name[h]}),u=tt("span","",{className:"spot"});return u.style.backgroundColor=Jn(a.subarray(3*h,3*h+3)),d.prepend(u),d}},...e.map(({name:h,position:d,delta_e_2000:u})=>({title:h,value:f=>u[f],cell:f=>tt("span",`${d[f]} ${u[f].toFixed(1)}`,{className:`where-${d[f]}`})})),{title:"Printed by",value:h=>t.printed_by[h]},{title:"Best",value:h=>t.best[h]}];this.table.show("Position and ΔE00 from the nearest colour of each gamut",c,r)}};async function Aw(i,t,e,n){let s=Object.entries(e).filter(([,a])=>a!==""),r=new URLSearchParams([["gamuts",i.join(",")],...s]);return await(await Ee(`/v1/matches?${r}`,{method:"POST",body:t,signal:n,headers:{"Content-Type":"application/octet-stream"}})).json()}function Tw(i){return`${i.slice(0,-1).join(", ")} and ${i.at(-1)}`}var Sg=.05,Cw=1600,Wi=[[0,255,236,110],[3,255,160,20],[6,226,40,50],[12,90,0,110]],yg=.45,Rw=" Printed, black is the black of the gamut (black-point compensation).",_c=class{constructor(t){this.page=t;L("picture-open").addEventListener("click",()=>this.file.click()),this.file.addEventListener("change",()=>{let[n]=this.file.files??[];this.file.value="",n!==void 0&&this.take(n)}),this.target.addEventListener("change",()=>{this.isChosen=!0,this.ask()}),this.limit.addEventListener("input",()=>this.draw()),L("picture-look").addEventListener("change",()=>this.draw()),L("picture-legend").append(...Wi.map(([n],s)=>tt("span",`${n}${s===Wi.length-1?"+":""}`))),L("picture-ramp").style.background=`linear-gradient(to right, ${Wi.map(([n,...s])=>`rgb(${s.join(" ")}) ${100*n/Wi.at(-1)[0]}%`).join(", ")})`;let e=L("picture-large");L("picture-enlarge").addEventListener("click",()=>e.showModal()),t.on(["slots"],()=>this.offer())}page;file=L("picture-file");target=L("picture-gamut");limit=L("picture-limit");isChosen=!1;given=null;picture=null;asking=new be;printing=new be;get against(){return this.target.selectedOptions[0]?.text??null}take(t){ec("picture"),this.given=t,this.ask()}offer(){let{shown:t}=this.page,e=this.target.value,n=t.map(({gamut:r})=>r.id);this.target.replaceChildren(...t.map(({gamut:r})=>tt("option",r.name,{value:r.id})));let[s]=[...t].sort((r,o)=>r.gamut.volume-o.gamut.volume);this.target.value=this.isChosen&&n.includes(e)?e:s?.gamut.id??"",L("picture-open").disabled=n.length===0,this.target.value!==e&&this.given!==null&&this.ask()}async ask(){let{given:t,target:{value:e}}=this;this.asking.end(),this.printing.end(),this.picture=null,this.draw(),L("picture-problem").hidden=!0,!(t===null||e==="")&&(L("picture-note").textContent=`${t.name} is compared …`,await this.asking.ask(async n=>{let s=await Gu(e,t,"heat-map",n);return Pw(t,await s.blob(),async()=>(await Gu(e,t,"picture",n)).blob())},n=>{this.picture=n,this.draw()},n=>{L("picture-note").textContent="",this.refuse(t,n)}))}refuse(t,e){L("picture-problem").replaceChildren(...si(e,t.name)),L("picture-problem").hidden=!1}get look(){return document.querySelector("#picture-look :checked").value}async print(t){if(this.printing.isAsking)return;let{width:e,height:n}=t.image;await this.printing.ask(async s=>Vu(await(await Gu(this.target.value,t.file,"picture",s)).blob(),e,n),s=>{t.printed=s,this.draw()},s=>this.refuse(t.file,s))}draw(){let{picture:t}=this,e=document.querySelector("#picture-look [value=original]");e.parentElement.hidden=t?.hasOriginal===!1;let n=this.look==="map";if(L("picture-view").hidden=L("picture-look").hidden=t===null,L("picture-limit-row").hidden=L("picture-legend-box").hidden=t===null||!n,t===null){L("picture-note").textContent="";return}let s=Number(this.limit.value)/Sg;L("picture-limit-text").textContent=`ΔE00 over ${this.limit.value}`;let r=t.counts.reduce((p,m,_)=>_>s?p+m:p,0),o=t.counts.reduce((p,m,_)=>_>0?p+m:p,0),a=p=>`${(100*p/t.pixels).toFixed(1)} %`,l=this.target.selectedOptions[0]?.text??"",c=`${a(r)} of the pixels of ${t.file.name} are out of reach of ${l} by more than ΔE00 ${this.limit.value}; ${a(o)} by any amount.`+(this.page.shown.find(({gamut:p})=>p.id===this.target.value)?.gamut.provenance.intent==="absolute"?"":Rw);L("picture-note").replaceChildren(...Eo(c));let{width:h,height:d}=t.image,{look:u}=this,{printed:f}=t,g=u==="printed"&&f===null;L("picture-view").setAttribute("aria-busy",String(g)),g&&this.print(t);let x=u==="map"?Iw(t.image,t.heat,s):u==="printed"&&f!==null?f:t.image;for(let p of["picture-canvas","picture-large-canvas"]){let m=L(p);Object.assign(m,{width:h,height:d}),m.getContext("2d").putImageData(x,0,0),m.setAttribute("aria-label",L("picture-note").textContent)}}};async function Pw(i,t,e){let n=await createImageBitmap(t,{colorSpaceConversion:"none"}),{width:s,height:r}=n,o=new Array(256).fill(0),a=bg(n,s,r);for(let f of a)o[f]+=1;let l=Math.min(1,Cw/Math.max(s,r)),c=[Math.max(1,Math.round(l*s)),Math.max(1,Math.round(l*r))],h=l===1?a:bg(n,...c),d=await Vu(i,...c).catch(()=>null),u=d===null?await Vu(await e(),...c):null;return{file:i,image:d??u,hasOriginal:d!==null,heat:h,counts:o,pixels:s*r,printed:u}}async function Vu(i,t,e){let n=await createImageBitmap(i,{imageOrientation:"none"}),s=new OffscreenCanvas(t,e).getContext("2d");return s.drawImage(n,0,0,t,e),s.getImageData(0,0,t,e)}function Gu(i,t,e,n){let s=e==="heat-map"?"&black_point_compensation=false":"",r=/jpeg|png/.test(t.type)?"":"&depth=16";return Ee(`/v1/gamuts/${i}/map?method=clip-nearest&result=${e}${s}${r}`,{method:"POST",body:t,signal:n,headers:{"Content-Type":"image/*",Accept:"image/png"}})}function Iw({width:i,height:t,data:e},n,s){let r=new ImageData(i,t),o=Array.from({length:256},(a,l)=>Lw(Sg*l));for(let a=0;a<n.length;a++){let l=4*a,c=.2126*e[l]+.7152*e[l+1]+.0722*e[l+2],h=yg*255+(1-yg)*c;r.data.set(n[a]>s?o[n[a]]:[h,h,h],l),r.data[l+3]=e[l+3]}return r}function Lw(i){let t=Wi.findIndex(([a],l)=>l>0&&(a>=i||l===Wi.length-1)),[e,...n]=Wi[t-1],[s,...r]=Wi[t],o=Math.min(1,(i-e)/(s-e));return n.map((a,l)=>a+o*(r[l]-a))}function bg(i,t,e){let n=new OffscreenCanvas(t,e).getContext("2d");n.imageSmoothingEnabled=!1,n.drawImage(i,0,0,t,e);let{data:s}=n.getImageData(0,0,t,e);return Uint8ClampedArray.from({length:t*e},(r,o)=>s[4*o])}var Ks=9094947017729282e-28,yc=class{planes;volume;resolution;start;listed;constructor(t){let e=t.length/9;this.planes=new Float64Array(12*e),this.volume=Dw(t,this.planes),this.resolution=Math.min(256,Math.max(4,Math.round(Math.sqrt(e)))),this.start=new Int32Array(6*this.resolution**2+1);let{start:n}=this;this.visit(t,r=>n[r+1]++);for(let r=1;r<n.length;r++)n[r]+=n[r-1];let s=n.slice();this.listed=new Int32Array(n.at(-1)),this.visit(t,(r,o)=>this.listed[s[r]++]=o)}faceTowards(t,e,n){let{planes:s,listed:r,start:o,resolution:a}=this,l=Math.abs(t),c=Math.abs(e),h=Math.abs(n),d=t>0?0:1,u=e/l,f=n/l;c>l&&c>=h?(d=e>0?2:3,u=n/c,f=t/c):h>l&&(d=n>0?4:5,u=t/h,f=e/h);let g=Math.min(a-1,Math.floor((u+1)*.5*a)),x=Math.min(a-1,Math.floor((f+1)*.5*a)),p=(d*a+g)*a+x,m=-1,_=-1/0;for(let M=o[p];M<o[p+1];M++){let y=12*r[M],T=s[y]*t+s[y+1]*e+s[y+2]*n,E=s[y+3]*t+s[y+4]*e+s[y+5]*n,v=s[y+6]*t+s[y+7]*e+s[y+8]*n,w=T<E?T<v?T:v:E<v?E:v;if(w>=0)return r[M];w>_&&(m=r[M],_=w)}return m}visit(t,e){let{planes:n,resolution:s}=this,r=o=>Math.min(s-1,Math.max(0,Math.floor((o+1)*.5*s)));for(let o=0;9*o<t.length;o++)for(let a=0;a<6;a++){let[l,c]=[a>>1,a%2===0?1:-1],[h,d]=[(l+1)%3,(l+2)%3],[u,f]=[!1,0],[g,x,p,m]=[1/0,-1/0,1/0,-1/0],[_,M,y,T]=[0,0,0,0];for(let N=9*o;N<9*o+9;N+=3){let O=c*t[N+l],V=t[N+h],C=t[N+d],H=O+Ks*Math.abs(O);O>0?f+=1:u=!0,V>H&&(M+=1),-V>H&&(_+=1),C>H&&(T+=1),-C>H&&(y+=1),g=Math.min(g,V/O),x=Math.max(x,V/O),p=Math.min(p,C/O),m=Math.max(m,C/O)}if(f===0||_===3||M===3||y===3||T===3)continue;u&&([g,x,p,m]=[-1,1,-1,1]);let[E,v]=[r(g-Ks),r(x+Ks)],[w,F]=[r(p-Ks),r(m+Ks)],D=E===v&&w===F;for(let N=E;N<=v;N++)for(let O=w;O<=F;O++)!D&&!Nw(n,o,a,N,O,s)||e((a*s+N)*s+O,o)}}};function Dw(i,t){let e=0;for(let n=0;9*n<i.length;n++){let[s,r]=[9*n,12*n],o=0;for(let a=0;a<9;a+=3){let[l,c]=[s+a,s+(a+3)%9],h=0;for(let d=0;d<3;d++){let[u,f]=[(d+1)%3,(d+2)%3],g=i[l+u]*i[c+f]-i[l+f]*i[c+u];t[r+a+d]=g,t[r+9+d]+=g,h+=g*g}if(a===0){if(o=t[r]*i[s+6]+t[r+1]*i[s+7]+t[r+2]*i[s+8],!(o>0))throw new RangeError(`face ${n} does not see the centre from its inner side`);e+=o}for(let d=0;d<3;d++)t[r+a+d]/=Math.sqrt(h)}for(let a=9;a<12;a++)t[r+a]/=o}return e/6}function Nw(i,t,e,n,s,r){let o=e>>1,a=e%2===0?1:-1;for(let l=12*t;l<12*t+9;l+=3){let[c,h,d]=[a*i[l+o],i[l+(o+1)%3],i[l+(o+2)%3]],u=(f,g)=>2*(f+(g>0?1:0))/r-1;if(c+h*u(n,h)+d*u(s,d)<-Ks)return!1}return!0}var Sc=class{point=new Float64Array(3);corners;boxes;children;ends;nodes=new Int32Array(64);bounds=new Float64Array(64);constructor(t){let e=t.length/9,n=Int32Array.from({length:e},(c,h)=>h),s=new Float64Array(3*e);for(let c=0;c<t.length;c++)s[3*Math.floor(c/9)+c%3]+=t[c];let[r,o,a]=[[],[],[]],l=(c,h)=>{let d=o.length,u=Uw(t,n.subarray(c,h));if(r.push(...u),o.push(-1-c),a.push(h),h-c<=4)return;let f=[0,1,2].map(x=>u[3+x]-u[x]),g=c+h>>1;Fw(n,s,f.indexOf(Math.max(...f)),c,h-1,g),l(c,g),o[d]=o.length,l(g,h)};l(0,e),this.boxes=Float64Array.from(r),this.children=Int32Array.from(o),this.ends=Int32Array.from(a),this.corners=new Float64Array(t.length),n.forEach((c,h)=>this.corners.set(t.subarray(9*c,9*c+9),9*h))}search(t,e,n,s){let{nodes:r,bounds:o,boxes:a,children:l,ends:c,corners:h,point:d}=this,u=s,f=1;for(r[0]=o[0]=0;f>0;){if(f-=1,o[f]>=u)continue;let g=r[f],x=l[g];if(x<0){for(let M=9*(-1-x);M<9*c[g];M+=9)u=Ow(h,M,t,e,n,u,d);continue}let p=Mg(a,g+1,t,e,n),m=Mg(a,x,t,e,n),_=p<=m;r[f]=_?x:g+1,o[f]=_?m:p,r[f+1]=_?g+1:x,o[f+1]=_?p:m,f+=2}return u}crossings({origin:t,direction:e,sideways:n,upwards:s}){let{nodes:r,boxes:o,children:a,ends:l,corners:c}=this,h=[],d=new Float64Array(9),u=1;for(r[0]=0;u>0;){u-=1;let f=r[u];if(!wg(o,f,t,n)||!wg(o,f,t,s))continue;let g=a[f];if(g>=0){r[u++]=g,r[u++]=f+1;continue}for(let x=9*(-1-g);x<9*l[f];x+=9){for(let m=0;m<9;m+=3)d[m]=$u(c,x+m,t,n),d[m+1]=$u(c,x+m,t,s),d[m+2]=$u(c,x+m,t,e);let p=Bw(d);p===p&&h.push(p)}}return Float64Array.from(h).sort()}};function Uw(i,t){let e=Float64Array.of(1/0,1/0,1/0,-1/0,-1/0,-1/0);for(let n of t)for(let s=0;s<9;s++){let r=i[9*n+s],o=s%3;r<e[o]&&(e[o]=r),r>e[3+o]&&(e[3+o]=r)}return e}function Fw(i,t,e,n,s,r){let o=a=>t[3*i[a]+e];for(;n<s;){let a=o(n+s>>1),[l,c]=[n,s];for(;l<=c;){for(;o(l)<a;)l+=1;for(;o(c)>a;)c-=1;if(l>c)break;[i[l],i[c]]=[i[c],i[l]],l+=1,c-=1}if(r<=c)s=c;else if(r>=l)n=l;else return}}function Mg(i,t,e,n,s){let r=6*t,o=e<i[r]?i[r]-e:e>i[r+3]?e-i[r+3]:0,a=n<i[r+1]?i[r+1]-n:n>i[r+4]?n-i[r+4]:0,l=s<i[r+2]?i[r+2]-s:s>i[r+5]?s-i[r+5]:0;return o*o+a*a+l*l}function Ow(i,t,e,n,s,r,o){let a=i[t],l=i[t+1],c=i[t+2],h=i[t+3]-a,d=i[t+4]-l,u=i[t+5]-c,f=i[t+6]-a,g=i[t+7]-l,x=i[t+8]-c,p=e-a,m=n-l,_=s-c,M=d*x-u*g,y=u*f-h*x,T=h*g-d*f,E=M*M+y*y+T*T,v=h*h+d*d+u*u,w=f*f+g*g+x*x,F=E<=1e-12*v*w,D=M*p+y*m+T*_;if(D*D>=r*E&&!F)return r;let N=M*(m*x-_*g)+y*(_*f-p*x)+T*(p*g-m*f),O=M*(d*_-u*m)+y*(u*p-h*_)+T*(h*m-d*p);if(N>=0&&O>=0&&N+O<=E&&E>0){let G=N/E,nt=O/E;if(r=bc(e,n,s,a+G*h+nt*f,l+G*d+nt*g,c+G*u+nt*x,r,o),!F)return r}let V=Wu(p*h+m*d+_*u,v);r=bc(e,n,s,a+V*h,l+V*d,c+V*u,r,o),V=Wu(p*f+m*g+_*x,w),r=bc(e,n,s,a+V*f,l+V*g,c+V*x,r,o);let C=f-h,H=g-d,X=x-u;return V=Wu((p-h)*C+(m-d)*H+(_-u)*X,C*C+H*H+X*X),bc(e,n,s,a+h+V*C,l+d+V*H,c+u+V*X,r,o)}function Wu(i,t){return i>0?i<t?i/t:1:0}function bc(i,t,e,n,s,r,o,a){let l=(i-n)*(i-n)+(t-s)*(t-s)+(e-r)*(e-r);return l>=o?o:(a[0]=n,a[1]=s,a[2]=r,l)}function $u(i,t,[e,n,s],[r,o,a]){return(i[t]-e)*r+(i[t+1]-n)*o+(i[t+2]-s)*a}function wg(i,t,e,n){let[s,r,o]=[0,0,0];for(let a=0;a<3;a++){let l=i[6*t+a]-e[a],c=i[6*t+3+a]-e[a];s+=(l+c)/2*n[a],r+=(c-l)/2*Math.abs(n[a]),o+=Math.abs(l)+Math.abs(c)}return Math.abs(s)<=r+1e-14*o}function Bw(i){let t=Xu(i,3,6),e=Xu(i,6,0),n=Xu(i,0,3),s=qu(i,3,6,t);if(qu(i,6,0,e)!==s||qu(i,0,3,n)!==s)return NaN;let r=t+e+n;return r===0?(i[2]+i[5]+i[8])/3:(t*i[2]+e*i[5]+n*i[8])/r}function Xu(i,t,e){return i[t]*i[e+1]-i[t+1]*i[e]}function qu(i,t,e,n){if(n!==0)return n>0;let s=i[t+1]-i[e+1];return s!==0?s>0:i[e]>i[t]}var uo=2**-40,kw=Math.sqrt(3)/2,fo=class i{constructor({positions:t,faces:e},n,s=0){this.centre=n;this.tolerance=s;let r=new Float64Array(3*e.length);for(let l=0;l<r.length;l++)r[l]=t[3*e[Math.floor(l/3)]+l%3]-n[l%3];this.corners=r,this.triangles=e.length/3,this.cones=new yc(r),this.volume=this.cones.volume;let[o,a]=[1/0,0];for(let l=0;l<this.triangles;l++){let c=12*l+9,{planes:h}=this.cones;o=Math.min(o,1/(h[c]**2+h[c+1]**2+h[c+2]**2))}for(let l=0;l<r.length;l+=3)a=Math.max(a,r[l]**2+r[l+1]**2+r[l+2]**2);this.inner=o*(1-uo),this.outer=a*(1+uo)}centre;tolerance;volume;triangles;cones;tree=null;corners;inner;outer;ends=null;static of(t,e){return e!==void 0&&t.refineTo(e),new i(t.level,t.header.centre,zw(t))}contains(t,e=this.tolerance){let[n,s,r]=this.centre,[o,a,l]=[t[0]-n,t[1]-s,t[2]-r];if(this.height(o,a,l)<=1)return!0;if(!(e>0))return!1;let c=Math.sqrt(this.outer)+e;if(o*o+a*a+l*l>c*c)return!1;let h=e*e*(1+uo);return this.faces.search(o,a,l,h)<h}distance(t){let[e,n,s]=this.centre,[r,o,a]=[t[0]-e,t[1]-n,t[2]-s],l=this.height(r,o,a)<=1,c=Math.sqrt(this.faces.search(r,o,a,1/0));return l?-c:c}nearest(t,e){let[n,s,r]=this.centre,[o,a,l]=[t[0]-n,t[1]-s,t[2]-r];Yu(o,a,l);let{point:c}=this.faces;return this.faces.search(o,a,l,1/0),Js(e,c[0]+n,c[1]+s,c[2]+r)}clip(t,e="nearest",n){let[s,r,o]=this.centre,[a,l,c]=[t[0]-s,t[1]-r,t[2]-o],h=this.height(a,l,c);if(h<=1)return Js(n,t[0],t[1],t[2]);if(e==="centre")return this.inwards(a/h,l/h,c/h,n);if(e==="chroma"){let u=this.atHue(t[0],t[1],t[2],n);if(u!==null)return u}else if(e!=="nearest")throw new RangeError(`there is no method ${String(e)}`);let{point:d}=this.faces;return this.faces.search(a,l,c,1/0),this.inwards(d[0],d[1],d[2],n)}chroma(t,e){let n=e*Math.PI/180;return this.intervals(t,Math.cos(n),Math.sin(n))}get faces(){return this.tree??=new Sc(this.corners)}height(t,e,n){if(t*t+e*e+n*n<this.inner)return 0;Yu(t,e,n);let{planes:r}=this.cones,o=12*this.cones.faceTowards(t,e,n)+9;return r[o]*t+r[o+1]*e+r[o+2]*n}inwards(t,e,n,s){let[r,o,a]=this.centre,l=1-uo;return Js(s,r+l*t,o+l*e,a+l*n)}intervals(t,e,n){let[s,r,o]=this.centre;Yu(t,e,n);let a=this.faces.crossings({origin:[t-s,-r,-o],direction:[0,e,n],sideways:[1,0,0],upwards:[0,-n,e]}),l=[];for(let c=0;c+1<a.length;c+=2){let[h,d]=[a[c],a[c+1]];d>=0&&l.push([Math.max(0,h),d])}return l}get axis(){if(this.ends!==null)return this.ends;let[t,e,n]=this.centre,s={origin:[-t,-e,-n],direction:[1,0,0],sideways:[0,1,0],upwards:[0,0,1]},r=this.faces.crossings(s);return this.ends=Float64Array.of(r[0]??NaN,r.at(-1)??NaN),this.ends}atHue(t,e,n,s){let r=uo*Math.sqrt(this.outer),[o,a]=[this.axis[0],this.axis[1]];if(t>a)return Js(s,a-r,0,0);if(t<o)return Js(s,o+r,0,0);let l=Math.hypot(e,n);if(l===0)return null;let c=this.intervals(t,e/l,n/l),h=c.findLast(([,x])=>x<=l),[d,u]=h??c[0]??[NaN,NaN],f=Math.min(r,(u-d)/2),g=h===void 0?d+f:u-f;return g>=0?Js(s,t,e/l*g,n/l*g):null}};function Js(i,t,e,n){let s=i??new Float64Array(3);return s[0]=t,s[1]=e,s[2]=n,s}function Yu(i,t,e){if(!(Math.abs(i)+Math.abs(t)+Math.abs(e)<1/0))throw new RangeError("a colour must be three finite numbers")}function zw({header:i,triangles:t}){let{levels:e=[],boundary_error:n=0}=i.gamut??{};return(e.findLast(r=>r.triangles<=t)?.distance_bound??0)+n+kw*i.step}function Hw(i,t,e){let{a:n,b:s,c:r}=i.face,o=i.barycoord.toArray();return Array.from({length:e},(a,l)=>[n,s,r].reduce((c,h,d)=>c+o[d]*t[e*h+l],0))}var Gw=600,Vw=4;function ju(i,t){return i!==null&&Math.hypot(i.clientX-t.clientX,i.clientY-t.clientY)<=Vw}var Mc=class{constructor(t){this.page=t;let e=0;new MutationObserver(()=>{clearTimeout(e),e=setTimeout(()=>this.box.hidden||t.announce(this.box.innerText.replaceAll(`
`,", ")),Gw)}).observe(this.box,{childList:!0,subtree:!0}),t.on(["slots","looks"],()=>{let{reading:n}=this,s=r=>t.shown.some(({gamut:o})=>o===r.gamut);n!==null&&(!s(n.subject)||!t.lookOf(n.subject.slot).isVisible||n.other&&!s(n.other))&&this.clear()}),t.view.onDraw.push(()=>this.placeMark()),addEventListener("keydown",({key:n})=>n==="Escape"&&this.release())}page;box=L("readout");mark=L("readout-mark");reading=null;keeper=null;get isKept(){return this.keeper!==null}show(t){this.reading?.answer!==t.answer&&this.reading?.answer.clear(),this.reading=t;let{subject:{gamut:e,slot:n},colour:s,lines:r,answer:o}=t,a=tt("strong",e.name,{title:e.name}),l=tt("span","",{className:"tint"});l.style.backgroundColor=Ze(n,this.page.isDark),a.prepend(l);let c=tt("span","",{className:"swatch"});c.style.backgroundColor=s,this.box.replaceChildren(a,c,...r.map(h=>tt("span",h)),o.element),this.box.hidden=!1}leave(){this.isKept||this.clear()}click(t,e){let n=ju(this.keeper,t);this.release(),!n&&(e(),this.reading!==null&&(this.keeper=t,this.box.classList.add("kept"),this.box.append(tt("small","Kept until Esc or another click")),this.placeMark()))}release(){this.isKept&&this.clear()}clear(){this.reading?.answer.clear(),this.reading=this.keeper=null,this.box.hidden=this.mark.hidden=!0,this.box.classList.remove("kept")}placeMark(){let{mark:t,page:e,reading:n}=this;if(t.hidden=!this.isKept||n===null,t.hidden)return;let s=new P().fromArray(n.point).applyMatrix4(yn(Se(n.subject.gamut)));t.style.translate=e.view.stagePlace(s).map(r=>`${r.toFixed(1)}px`).join(" ")}};function Tg(i,t,e){let n=(a,l)=>Hw(e,a,l),[s,r]=[n(t.positions,3),n(t.colours,3)],o=Zu(Se(i),s);return Vp(Float32Array.from(r))[0]>Gp&&o.push(`Outside ${ge==="srgb"?"sRGB":"Display P3"}: the screen shows a similar colour`),t.device!==null&&o.push(Ou(i.channels,n(t.device,i.channels.length))),{point:s,colour:Jn(r),lines:o}}function Zu(i,t){let e=Math.max(...t.map(Math.abs))<5?4:1,n=[i.map((s,r)=>`${s} ${Lg(t[r],e)}`).join("  ")];if(i[0]!=="X"){let[s,r]=Wp(t[1],t[2]);n.push(`C ${s.toFixed(e)}  h ${r.toFixed(1)}°`)}return n}var Qs=class{constructor(t=0){this.pause=t}pause;element=tt("span");busy=!1;wish=null;asking=new AbortController;ask(t,e=""){this.wish=t,this.element.textContent===""&&(this.element.textContent=e),this.busy||this.answer()}clear(){this.wish=null,this.asking.abort(),this.element.replaceChildren()}async answer(){for(this.busy=!0;this.wish!==null;){this.pause>0&&await new Promise(s=>setTimeout(s,this.pause));let t=this.wish;if(t===null)break;this.wish=null,this.asking=new AbortController;let{signal:e}=this.asking,n=await t(e).catch(()=>[]);e.aborted||this.element.replaceChildren(...n.map(s=>tt("span",s)))}this.busy=!1}};async function Cg(i,t,e){return[$w(i.name,await ac(i,[t],e))]}var Ag=new WeakMap,Ww=5e4;function Rg(i,t,e){if(t===null||t.triangles>Ww)return[];let n=Ag.get(t)??new fo(t,i.centre);Ag.set(t,n);let s=n.distance(e),r=s>0?"outside":"inside";return[`Euclidean distance ${Ig(s)} from ${i.name}: ${r} (${t.triangles} triangles)`]}async function Pg(i,t,e){let n=await hc(i,[t],e),{channels:s}=i,r=rc(n,0),o=r===null?"":`; ${oc(s)} can be ${r} %`;return[`${n.inside[0]?"Recipe":"Outside; recipe of the nearest colour"}: ΔE00 ${n.delta_e_2000[0].toFixed(2)}${o}`,Ou(s,n.device[0])]}function $w(i,t){let e=t.distance[0];return`Euclidean distance ${Ig(e)} from ${i}: ${t.position[0]} (${lc(t)})`}function Ig(i){return Lg(i,Math.abs(i)<.1?4:2)}function Lg(i,t){return i.toFixed(t).replace("-","−")}function Dg(i,t){let{canvas:e,view:n}=i,s=new Qs,r=null,o=null,a=null,l=h=>{a=h,r===null&&requestAnimationFrame(()=>{r!==null&&r.buttons<=1&&!t.isKept&&c(r),r=null}),r=h};e.addEventListener("pointermove",l),e.addEventListener("pointerdown",h=>{o=h,l(h)}),e.addEventListener("click",h=>ju(o,h)&&t.click(h,()=>c(h))),e.addEventListener("keydown",({key:h})=>{if(h!=="Enter")return;let{left:d,top:u,width:f,height:g}=e.getBoundingClientRect();if(t.isKept)return t.release();let x={clientX:d+f/2,clientY:u+g/2};for(let p of[a,x])p!==null&&!t.isKept&&t.click(p,()=>c(p))}),e.addEventListener("pointerleave",h=>{h.pointerType==="mouse"&&(a=r=null,t.leave())});function c({clientX:h,clientY:d}){let u=i.readable.flatMap(E=>E.targets()),f=(E,v=[])=>n.pick(h,d,[...v,...i.shown.flatMap(({layer:w})=>w.targets[E])]),g=f("solid",u)??f("shell"),x=i.readable.find(E=>E.targets().some(v=>v===g?.object));if(g===null)return t.leave();if(x!==void 0)return x.read(g);let p=i.shown.find(({layer:E})=>g.object.parent===E.group),{gamut:m,layer:_}=p,M=i.shown.find(E=>E!==p),y=Tg(m,_.level,g),T=M?.gamut.options.space===m.options.space?M:void 0;T!==void 0&&qt===null?s.ask(E=>Cg(T.gamut,y.point,E)):(s.clear(),T!==void 0&&y.lines.push(...Rg(T.gamut,T.layer.level,y.point))),t.show({...y,subject:p,other:M,answer:s})}}ft.line={worldUnits:{value:1},linewidth:{value:1},resolution:{value:new Ct},dashOffset:{value:0},dashScale:{value:1},dashSize:{value:1},gapSize:{value:1}};nn.line={uniforms:qr.merge([ft.common,ft.fog,ft.line]),vertexShader:`
		#include <common>
		#include <color_pars_vertex>
		#include <fog_pars_vertex>
		#include <logdepthbuf_pars_vertex>
		#include <clipping_planes_pars_vertex>

		uniform float linewidth;
		uniform vec2 resolution;

		attribute vec3 instanceStart;
		attribute vec3 instanceEnd;

		attribute vec3 instanceColorStart;
		attribute vec3 instanceColorEnd;

		#ifdef WORLD_UNITS

			varying vec4 worldPos;
			varying vec3 worldStart;
			varying vec3 worldEnd;

			#ifdef USE_DASH

				varying vec2 vUv;

			#endif

		#else

			varying vec2 vUv;

		#endif

		#ifdef USE_DASH

			uniform float dashScale;
			attribute float instanceDistanceStart;
			attribute float instanceDistanceEnd;
			varying float vLineDistance;

		#endif

		float trimSegmentAlpha( const in vec4 start, const in vec4 end ) {

			// compute the interpolation factor needed to trim the segment so it terminates
			// between the camera plane and the near plane

			// conservative estimate of the near plane
			float a = projectionMatrix[ 2 ][ 2 ]; // 3nd entry in 3th column
			float b = projectionMatrix[ 3 ][ 2 ]; // 3nd entry in 4th column

			// we need different nearEstimate formula for reversed and default depth buffer
			// a is positive with a reversed depth buffer so it can be used for controlling the code flow
			float nearEstimate = ( a > 0.0 ) ? ( - b / ( a + 1.0 ) ) : ( - 0.5 * b / a );

			return ( nearEstimate - start.z ) / ( end.z - start.z );

		}

		void main() {

			#ifdef USE_COLOR

				vColor.xyz = ( position.y < 0.5 ) ? instanceColorStart : instanceColorEnd;

			#endif

			float aspect = resolution.x / resolution.y;

			// camera space
			vec4 start = modelViewMatrix * vec4( instanceStart, 1.0 );
			vec4 end = modelViewMatrix * vec4( instanceEnd, 1.0 );

			#ifdef USE_DASH

				float lineDistanceStart = dashScale * instanceDistanceStart;
				float lineDistanceEnd = dashScale * instanceDistanceEnd;

			#endif

			#ifdef WORLD_UNITS

				worldStart = start.xyz;
				worldEnd = end.xyz;

			#else

				vUv = uv;

			#endif

			// special case for perspective projection, and segments that terminate either in, or behind, the camera plane
			// clearly the gpu firmware has a way of addressing this issue when projecting into ndc space
			// but we need to perform ndc-space calculations in the shader, so we must address this issue directly
			// perhaps there is a more elegant solution -- WestLangley

			bool perspective = ( projectionMatrix[ 2 ][ 3 ] == - 1.0 ); // 4th entry in the 3rd column

			if ( perspective ) {

				if ( start.z < 0.0 && end.z >= 0.0 ) {

					float alpha = trimSegmentAlpha( start, end );
					end.xyz = mix( start.xyz, end.xyz, alpha );

					#ifdef USE_DASH

						lineDistanceEnd = mix( lineDistanceStart, lineDistanceEnd, alpha );

					#endif

				} else if ( end.z < 0.0 && start.z >= 0.0 ) {

					float alpha = trimSegmentAlpha( end, start );
					start.xyz = mix( end.xyz, start.xyz, alpha );

					#ifdef USE_DASH

						lineDistanceStart = mix( lineDistanceEnd, lineDistanceStart, alpha );

					#endif

				}

			}

			#ifdef USE_DASH

				vLineDistance = ( position.y < 0.5 ) ? lineDistanceStart : lineDistanceEnd;
				vUv = uv;

			#endif

			// clip space
			vec4 clipStart = projectionMatrix * start;
			vec4 clipEnd = projectionMatrix * end;

			// ndc space
			vec3 ndcStart = clipStart.xyz / clipStart.w;
			vec3 ndcEnd = clipEnd.xyz / clipEnd.w;

			// direction
			vec2 dir = ndcEnd.xy - ndcStart.xy;

			// account for clip-space aspect ratio
			dir.x *= aspect;
			dir = normalize( dir );

			#ifdef WORLD_UNITS

				vec3 worldDir = normalize( end.xyz - start.xyz );
				vec3 tmpFwd = perspective ? normalize( mix( start.xyz, end.xyz, 0.5 ) ) : vec3( 0.0, 0.0, - 1.0 );
				vec3 worldUp = normalize( cross( worldDir, tmpFwd ) );
				vec3 worldFwd = cross( worldDir, worldUp );
				worldPos = position.y < 0.5 ? start: end;

				// height offset
				float hw = linewidth * 0.5;
				worldPos.xyz += position.x < 0.0 ? hw * worldUp : - hw * worldUp;

				// don't extend the line if we're rendering dashes because we
				// won't be rendering the endcaps
				#ifndef USE_DASH

					// cap extension
					worldPos.xyz += position.y < 0.5 ? - hw * worldDir : hw * worldDir;

					// add width to the box
					worldPos.xyz += worldFwd * hw;

					// endcaps
					if ( position.y > 1.0 || position.y < 0.0 ) {

						worldPos.xyz -= worldFwd * 2.0 * hw;

					}

				#endif

				// project the worldpos
				vec4 clip = projectionMatrix * worldPos;

				// shift the depth of the projected points so the line
				// segments overlap neatly
				vec3 clipPose = ( position.y < 0.5 ) ? ndcStart : ndcEnd;

				// only shift the depth of vertices in front of the camera (#35137)
				if ( clip.w > 0.0 ) clip.z = clipPose.z * clip.w;

			#else

				vec2 offset = vec2( dir.y, - dir.x );
				// undo aspect ratio adjustment
				dir.x /= aspect;
				offset.x /= aspect;

				// sign flip
				if ( position.x < 0.0 ) offset *= - 1.0;

				// endcaps
				if ( position.y < 0.0 ) {

					offset += - dir;

				} else if ( position.y > 1.0 ) {

					offset += dir;

				}

				// adjust for linewidth
				offset *= linewidth;

				// adjust for clip-space to screen-space conversion // maybe resolution should be based on viewport ...
				offset /= resolution.y;

				// select end
				vec4 clip = ( position.y < 0.5 ) ? clipStart : clipEnd;

				// back to clip space
				offset *= clip.w;

				clip.xy += offset;

			#endif

			gl_Position = clip;

			vec4 mvPosition = ( position.y < 0.5 ) ? start : end; // this is an approximation

			#include <logdepthbuf_vertex>
			#include <clipping_planes_vertex>
			#include <fog_vertex>

		}
		`,fragmentShader:`
		uniform vec3 diffuse;
		uniform float opacity;
		uniform float linewidth;

		#ifdef USE_DASH

			uniform float dashOffset;
			uniform float dashSize;
			uniform float gapSize;

		#endif

		varying float vLineDistance;

		#ifdef WORLD_UNITS

			varying vec4 worldPos;
			varying vec3 worldStart;
			varying vec3 worldEnd;

			#ifdef USE_DASH

				varying vec2 vUv;

			#endif

		#else

			varying vec2 vUv;

		#endif

		#include <common>
		#include <color_pars_fragment>
		#include <fog_pars_fragment>
		#include <logdepthbuf_pars_fragment>
		#include <clipping_planes_pars_fragment>

		vec2 closestLineToLine(vec3 p1, vec3 p2, vec3 p3, vec3 p4) {

			float mua;
			float mub;

			vec3 p13 = p1 - p3;
			vec3 p43 = p4 - p3;

			vec3 p21 = p2 - p1;

			float d1343 = dot( p13, p43 );
			float d4321 = dot( p43, p21 );
			float d1321 = dot( p13, p21 );
			float d4343 = dot( p43, p43 );
			float d2121 = dot( p21, p21 );

			float denom = d2121 * d4343 - d4321 * d4321;

			float numer = d1343 * d4321 - d1321 * d4343;

			mua = numer / denom;
			mua = clamp( mua, 0.0, 1.0 );
			mub = ( d1343 + d4321 * ( mua ) ) / d4343;
			mub = clamp( mub, 0.0, 1.0 );

			return vec2( mua, mub );

		}

		void main() {

			float alpha = opacity;
			vec4 diffuseColor = vec4( diffuse, alpha );

			#include <clipping_planes_fragment>

			#ifdef USE_DASH

				if ( vUv.y < - 1.0 || vUv.y > 1.0 ) discard; // discard endcaps

				if ( mod( vLineDistance + dashOffset, dashSize + gapSize ) > dashSize ) discard; // todo - FIX

			#endif

			#ifdef WORLD_UNITS

				float len;

				if ( isOrthographic ) {

					// View rays are parallel to the z axis so the distance reduces to camera-space XY
					vec2 lineDir = worldEnd.xy - worldStart.xy;
					float t = clamp( dot( worldPos.xy - worldStart.xy, lineDir ) / dot( lineDir, lineDir ), 0.0, 1.0 );
					len = length( worldStart.xy + lineDir * t - worldPos.xy );

				} else {

					// Find the closest points on the view ray and the line segment
					vec3 rayEnd = normalize( worldPos.xyz ) * 1e5;
					vec3 lineDir = worldEnd - worldStart;
					vec2 params = closestLineToLine( worldStart, worldEnd, vec3( 0.0, 0.0, 0.0 ), rayEnd );

					vec3 p1 = worldStart + lineDir * params.x;
					vec3 p2 = rayEnd * params.y;
					vec3 delta = p1 - p2;
					len = length( delta );

				}

				float norm = len / linewidth;

				#ifndef USE_DASH

					#ifdef USE_ALPHA_TO_COVERAGE

						float dnorm = fwidth( norm );
						alpha = 1.0 - smoothstep( 0.5 - dnorm, 0.5 + dnorm, norm );

					#else

						if ( norm > 0.5 ) {

							discard;

						}

					#endif

				#endif

			#else

				#ifdef USE_ALPHA_TO_COVERAGE

					// artifacts appear on some hardware if a derivative is taken within a conditional
					float a = vUv.x;
					float b = ( vUv.y > 0.0 ) ? vUv.y - 1.0 : vUv.y + 1.0;
					float len2 = a * a + b * b;
					float dlen = fwidth( len2 );

					if ( abs( vUv.y ) > 1.0 ) {

						alpha = 1.0 - smoothstep( 1.0 - dlen, 1.0 + dlen, len2 );

					}

				#else

					if ( abs( vUv.y ) > 1.0 ) {

						float a = vUv.x;
						float b = ( vUv.y > 0.0 ) ? vUv.y - 1.0 : vUv.y + 1.0;
						float len2 = a * a + b * b;

						if ( len2 > 1.0 ) discard;

					}

				#endif

			#endif

			#include <logdepthbuf_fragment>
			#include <color_fragment>

			gl_FragColor = vec4( diffuseColor.rgb, alpha );

			#include <tonemapping_fragment>
			#include <colorspace_fragment>
			#include <fog_fragment>
			#include <premultiplied_alpha_fragment>

		}
		`};var tr=class extends Ln{constructor(t){super({type:"LineMaterial",uniforms:qr.clone(nn.line.uniforms),vertexShader:nn.line.vertexShader,fragmentShader:nn.line.fragmentShader,clipping:!0}),this.isLineMaterial=!0,this.setValues(t)}get color(){return this.uniforms.diffuse.value}set color(t){this.uniforms.diffuse.value=t}get worldUnits(){return"WORLD_UNITS"in this.defines}set worldUnits(t){t===!0!==this.worldUnits&&(this.needsUpdate=!0),t===!0?this.defines.WORLD_UNITS="":delete this.defines.WORLD_UNITS}get linewidth(){return this.uniforms.linewidth.value}set linewidth(t){this.uniforms.linewidth&&(this.uniforms.linewidth.value=t)}get dashed(){return"USE_DASH"in this.defines}set dashed(t){t===!0!==this.dashed&&(this.needsUpdate=!0),t===!0?this.defines.USE_DASH="":delete this.defines.USE_DASH}get dashScale(){return this.uniforms.dashScale.value}set dashScale(t){this.uniforms.dashScale.value=t}get dashSize(){return this.uniforms.dashSize.value}set dashSize(t){this.uniforms.dashSize.value=t}get dashOffset(){return this.uniforms.dashOffset.value}set dashOffset(t){this.uniforms.dashOffset.value=t}get gapSize(){return this.uniforms.gapSize.value}set gapSize(t){this.uniforms.gapSize.value=t}get opacity(){return this.uniforms.opacity.value}set opacity(t){this.uniforms&&(this.uniforms.opacity.value=t)}get resolution(){return this.uniforms.resolution.value}set resolution(t){this.uniforms.resolution.value.copy(t)}get alphaToCoverage(){return"USE_ALPHA_TO_COVERAGE"in this.defines}set alphaToCoverage(t){this.defines&&(t===!0!==this.alphaToCoverage&&(this.needsUpdate=!0),t===!0?this.defines.USE_ALPHA_TO_COVERAGE="":delete this.defines.USE_ALPHA_TO_COVERAGE)}};var Ng=new ve,wc=new P,er=class extends Ur{constructor(){super(),this.isLineSegmentsGeometry=!0,this.type="LineSegmentsGeometry";let t=[-1,2,0,1,2,0,-1,1,0,1,1,0,-1,0,0,1,0,0,-1,-1,0,1,-1,0],e=[-1,2,1,2,-1,1,1,1,-1,-1,1,-1,-1,-2,1,-2],n=[0,2,1,2,3,1,2,4,3,4,5,3,4,6,5,6,7,5];this.setIndex(n),this.setAttribute("position",new Qt(t,3)),this.setAttribute("uv",new Qt(e,2))}applyMatrix4(t){let e=this.attributes.instanceStart,n=this.attributes.instanceEnd;return e!==void 0&&(e.applyMatrix4(t),n.applyMatrix4(t),e.needsUpdate=!0),this.boundingBox!==null&&this.computeBoundingBox(),this.boundingSphere!==null&&this.computeBoundingSphere(),this}setPositions(t){let e;t instanceof Float32Array?e=t:Array.isArray(t)&&(e=new Float32Array(t));let n=new Oi(e,6,1);return this.setAttribute("instanceStart",new Bn(n,3,0)),this.setAttribute("instanceEnd",new Bn(n,3,3)),this.instanceCount=this.attributes.instanceStart.count,this.computeBoundingBox(),this.computeBoundingSphere(),this}setColors(t){let e;t instanceof Float32Array?e=t:Array.isArray(t)&&(e=new Float32Array(t));let n=new Oi(e,6,1);return this.setAttribute("instanceColorStart",new Bn(n,3,0)),this.setAttribute("instanceColorEnd",new Bn(n,3,3)),this}fromWireframeGeometry(t){return this.setPositions(t.attributes.position.array),this}fromEdgesGeometry(t){return this.setPositions(t.attributes.position.array),this}fromMesh(t){return this.fromWireframeGeometry(new Lr(t.geometry)),this}fromLineSegments(t){let e=t.geometry;return this.setPositions(e.attributes.position.array),this}computeBoundingBox(){this.boundingBox===null&&(this.boundingBox=new ve);let t=this.attributes.instanceStart,e=this.attributes.instanceEnd;t!==void 0&&e!==void 0&&(this.boundingBox.setFromBufferAttribute(t),Ng.setFromBufferAttribute(e),this.boundingBox.union(Ng))}computeBoundingSphere(){this.boundingSphere===null&&(this.boundingSphere=new ln),this.boundingBox===null&&this.computeBoundingBox();let t=this.attributes.instanceStart,e=this.attributes.instanceEnd;if(t!==void 0&&e!==void 0){let n=this.boundingSphere.center;this.boundingBox.getCenter(n);let s=0;for(let r=0,o=t.count;r<o;r++)wc.fromBufferAttribute(t,r),s=Math.max(s,n.distanceToSquared(wc)),wc.fromBufferAttribute(e,r),s=Math.max(s,n.distanceToSquared(wc));this.boundingSphere.radius=Math.sqrt(s),isNaN(this.boundingSphere.radius)&&console.error("THREE.LineSegmentsGeometry.computeBoundingSphere(): Computed radius is NaN. The instanced position data is likely to have NaN values.",this)}}toJSON(){}};var Ku=new ne,Ug=new P,Fg=new P,ke=new ne,ze=new ne,ti=new ne,Ju=new P,Qu=new jt,He=new Or,Og=new P,Ec=new ve,Ac=new ln,ei=new ne,ni,ls;function Bg(i,t,e){return ei.set(0,0,-t,1).applyMatrix4(i.projectionMatrix),ei.multiplyScalar(1/ei.w),ei.x=ls/e.width,ei.y=ls/e.height,ei.applyMatrix4(i.projectionMatrixInverse),ei.multiplyScalar(1/ei.w),Math.abs(Math.max(ei.x,ei.y))}function Xw(i,t){let e=i.matrixWorld,n=i.geometry,s=n.attributes.instanceStart,r=n.attributes.instanceEnd,o=Math.min(n.instanceCount,s.count);for(let a=0,l=o;a<l;a++){He.start.fromBufferAttribute(s,a),He.end.fromBufferAttribute(r,a),He.applyMatrix4(e);let c=new P,h=new P;ni.distanceSqToSegment(He.start,He.end,h,c),h.distanceTo(c)<ls*.5&&t.push({point:h,pointOnLine:c,distance:ni.origin.distanceTo(h),object:i,face:null,faceIndex:a,uv:null,uv1:null})}}function qw(i,t,e){let n=t.projectionMatrix,r=i.material.resolution,o=i.matrixWorld,a=i.geometry,l=a.attributes.instanceStart,c=a.attributes.instanceEnd,h=Math.min(a.instanceCount,l.count),d=-t.near;ni.at(1,ti),ti.w=1,ti.applyMatrix4(t.matrixWorldInverse),ti.applyMatrix4(n),ti.multiplyScalar(1/ti.w),ti.x*=r.x/2,ti.y*=r.y/2,ti.z=0,Ju.copy(ti),Qu.multiplyMatrices(t.matrixWorldInverse,o);for(let u=0,f=h;u<f;u++){if(ke.fromBufferAttribute(l,u),ze.fromBufferAttribute(c,u),ke.w=1,ze.w=1,ke.applyMatrix4(Qu),ze.applyMatrix4(Qu),ke.z>d&&ze.z>d)continue;if(ke.z>d){let M=ke.z-ze.z,y=(ke.z-d)/M;ke.lerp(ze,y)}else if(ze.z>d){let M=ze.z-ke.z,y=(ze.z-d)/M;ze.lerp(ke,y)}ke.applyMatrix4(n),ze.applyMatrix4(n),ke.multiplyScalar(1/ke.w),ze.multiplyScalar(1/ze.w),ke.x*=r.x/2,ke.y*=r.y/2,ze.x*=r.x/2,ze.y*=r.y/2,He.start.copy(ke),He.start.z=0,He.end.copy(ze),He.end.z=0;let x=He.closestPointToPointParameter(Ju,!0);He.at(x,Og);let p=_i.lerp(ke.z,ze.z,x),m=p>=-1&&p<=1,_=Ju.distanceTo(Og)<ls*.5;if(m&&_){He.start.fromBufferAttribute(l,u),He.end.fromBufferAttribute(c,u),He.start.applyMatrix4(o),He.end.applyMatrix4(o);let M=new P,y=new P;ni.distanceSqToSegment(He.start,He.end,y,M),e.push({point:y,pointOnLine:M,distance:ni.origin.distanceTo(y),object:i,face:null,faceIndex:u,uv:null,uv1:null})}}}var Tc=class extends me{constructor(t=new er,e=new tr({color:Math.random()*16777215})){super(t,e),this.isLineSegments2=!0,this.type="LineSegments2"}computeLineDistances(){let t=this.geometry,e=t.attributes.instanceStart,n=t.attributes.instanceEnd,s=new Float32Array(2*e.count);for(let o=0,a=0,l=e.count;o<l;o++,a+=2)Ug.fromBufferAttribute(e,o),Fg.fromBufferAttribute(n,o),s[a]=a===0?0:s[a-1],s[a+1]=s[a]+Ug.distanceTo(Fg);let r=new Oi(s,2,1);return t.setAttribute("instanceDistanceStart",new Bn(r,1,0)),t.setAttribute("instanceDistanceEnd",new Bn(r,1,1)),this}raycast(t,e){let n=this.material.worldUnits,s=t.camera;if(s===null&&!n&&console.error('LineSegments2: "Raycaster.camera" needs to be set in order to raycast against LineSegments2 while worldUnits is set to false.'),n===!1&&(this.material.resolution.x===0||this.material.resolution.y===0))return;let r=t.params.Line2!==void 0&&t.params.Line2.threshold||0;ni=t.ray;let o=this.matrixWorld,a=this.geometry,l=this.material;ls=l.linewidth+r,a.boundingSphere===null&&a.computeBoundingSphere(),Ac.copy(a.boundingSphere).applyMatrix4(o);let c;if(n)c=ls*.5;else{let d=Math.max(s.near,Ac.distanceToPoint(ni.origin));c=Bg(s,d,l.resolution)}if(Ac.radius+=c,ni.intersectsSphere(Ac)===!1)return;a.boundingBox===null&&a.computeBoundingBox(),Ec.copy(a.boundingBox).applyMatrix4(o);let h;if(n)h=ls*.5;else{let d=Math.max(s.near,Ec.distanceToPoint(ni.origin));h=Bg(s,d,l.resolution)}Ec.expandByScalar(h),ni.intersectsBox(Ec)!==!1&&(n?Xw(this,e):qw(this,s,e))}onBeforeRender(t){let e=this.material.uniforms;e&&e.resolution&&(t.getViewport(Ku),this.material.uniforms.resolution.value.set(Ku.z,Ku.w))}};function zg(i,t,e){let n=i.length/3,s=new Float64Array(n);for(let l=0;l<n;l++)s[l]=e(i[3*l],i[3*l+1],i[3*l+2]);let r=(l,c)=>Math.min(l,c)*n+Math.max(l,c),o=new Map;for(let l=0;l<t.length;l+=3){let c=-1,h=-1;for(let d=0;d<3;d++){let u=t[l+d],f=t[l+(d+1)%3],g=s[u]>=0;g!==s[f]>=0&&(g?c=r(u,f):h=r(u,f))}c>=0&&o.set(c,h)}let a=[];for(let l=o.keys().next();!l.done;l=o.keys().next()){let c=[];for(let d=l.value;o.has(d);){c.push(d);let u=o.get(d);o.delete(d),d=u}let h=new Float32Array(3*c.length);c.forEach((d,u)=>{let f=Math.floor(d/n),g=d%n,x=s[f]/(s[f]-s[g]);for(let p=0;p<3;p++){let m=i[3*f+p];h[3*u+p]=m+x*(i[3*g+p]-m)}}),a.push(h)}return a}function td(i,t){let[e,n]=t===0?[1,2]:[0,2],s=(a,l,c)=>{let h=[0,0,0];return h[t]=a,h[e]=l,h[n]=c,h};if(i.kind==="lightness")return kg(s(i.value,0,0),s(0,1,0),s(0,0,1));let[r,o]=Zw(i.value);return kg([0,0,0],s(0,r,o),s(1,0,0))}function Hg({origin:i,normal:t}){let[e,n,s]=t,r=e*i[0]+n*i[1]+s*i[2];return(o,a,l)=>e*o+n*a+s*l-r}function ed({origin:i,right:t,up:e},n){return Array.from({length:n.length/3},(s,r)=>{let[o,a,l]=[0,1,2].map(c=>n[3*r+c]-i[c]);return[o*t[0]+a*t[1]+l*t[2],o*e[0]+a*e[1]+l*e[2]]})}function Mi({origin:i,right:t,up:e},[n,s]){return i.map((r,o)=>r+n*t[o]+s*e[o])}function Gg(i){return i.flatMap((t,e)=>{let[n,s]=t,[r,o]=i.at(e-1),a=n>=0==r>=0?[]:[[0,o+(s-o)*r/(r-n)]];return n>=0?[...a,t]:a})}function Vg(i){let t=i.map(e=>e.reduce((n,[s,r],o)=>{let[a,l]=e.at(o-1);return n+(a*r-s*l)/2},0));return Math.abs(t.reduce((e,n)=>e+n,0))}function Wg(i){let t=i.map(n=>i.filter(s=>s!==n&&Yw(n[0],s))),e=new Map(i.filter((n,s)=>t[s].length%2===0).map(n=>[n,[n]]));return i.forEach((n,s)=>{if(e.has(n))return;let r=a=>t[i.indexOf(a)].length,o=t[s].filter(a=>e.has(a)).sort((a,l)=>r(l)-r(a))[0];o!==void 0&&e.get(o).push(n)}),[...e.values()]}function Yw([i,t],e){return e.reduce((n,[s,r],o)=>{let[a,l]=e.at(o-1);return t<r==t<l||i>a+(t-l)*(s-a)/(r-l)?n:!n},!1)}function kg(i,t,e){return{origin:i,right:t,up:e,normal:jw(t,e)}}function jw([i,t,e],[n,s,r]){return[t*r-e*s,e*n-i*r,i*s-t*n]}function Zw(i){let t=i*Math.PI/180;return[Math.cos(t),Math.sin(t)]}var Kw=2.2,$g=4.6,Jw=1/420,Qw={polygonOffset:!0,polygonOffsetFactor:2,polygonOffsetUnits:4},Cc=class{constructor(t){this.view=t;t.renderer.localClippingEnabled=!0,this.group.add(this.cap,this.frame,this.lines),this.group.matrixAutoUpdate=!1,this.cap.frustumCulled=this.frame.frustumCulled=!1}view;cap=new me(new he,new Cn({side:en,...Qw}));group=new Ne;frame=new Rn(new he,new mn({transparent:!0,opacity:.55}));lines=new Ne;materials=new Map;kept=new Xe;plane=new Xe;half="front";turn=null;get isAboveCut(){if(this.half!=="front")return this.half==="above";let{camera:t}=this.view;return this.view.projection==="perspective"?this.plane.distanceToPoint(t.position)>=0:t.getWorldDirection(new P).dot(this.plane.normal)<=0}show({plane:t,turn:e,frame:n,raster:s,layers:r,half:o,ink:a,back:l}){this.half=o,this.turn=e,this.group.matrix.copy(e),this.group.matrixWorldNeedsUpdate=!0;let c=new P(...t.normal).transformDirection(e);this.plane.setFromNormalAndCoplanarPoint(c,new P(...t.origin).applyMatrix4(e));let h=o!=="none";for(let{layer:u}of r)u.clip(h?[this.kept]:null);this.view.kept=h?this.kept:null,this.fill(t,n,s,r.flatMap(({outlines:u,isFilled:f})=>f?Wg(u):[])),this.drawFrame(t,n,a),this.clearLines();let d=Jw*(n[0][1]-n[0][0]);for(let{outlines:u,colour:f,order:g}of r){let[x=0,p=0]=bi[g].split(" ").map(y=>d*Number(y)),_=u.map(y=>y.map(T=>Mi(t,T))).flatMap(y=>y.flatMap((T,E)=>[...y.at(E-1),...T]));if(_.length===0)continue;let M=new er().setPositions(_);for(let[y,T,E]of[[$g,l,0],[Kw,f,p]]){let v=this.material(`${T} ${y} ${g}`,T,y);Object.assign(v,{dashed:E>0,dashSize:x,gapSize:E});let w=new Tc(M,v).computeLineDistances();w.frustumCulled=!1,w.renderOrder=y===$g?1:2,this.lines.add(w)}}this.view.scene.add(this.group),this.follow()}hide(t){for(let e of t)e.clip(null);this.view.kept=null,this.clearLines(),this.group.removeFromParent(),this.turn=null}follow(){if(this.turn===null)return;let t=this.isAboveCut;this.kept.copy(this.plane),t&&this.kept.negate();for(let e of this.materials.values())e.depthTest=this.half!=="front"}pointOf(t){return t.clone().applyMatrix4(this.turn.clone().invert()).toArray()}screen(t){return this.view.stagePlace(new P(...t).applyMatrix4(this.turn))}fill(t,[[e,n],[s,r]],o,a){let l=[],c=[],h=[];for(let g of a){let[x,...p]=g.map(_=>_.map(([M,y])=>new Ct(M,y))),m=l.length/3;for(let _ of Pr.triangulateShape(x,p))h.push(..._.map(M=>m+M));for(let{x:_,y:M}of[x,...p].flat())l.push(...Mi(t,[_,M])),c.push((_-e)/(n-e),(r-M)/(r-s))}let{geometry:d,material:u}=this.cap;d.dispose(),d.setAttribute("position",new Qt(l,3)),d.setAttribute("uv",new Qt(c,2)),d.setIndex(h),d.computeBoundingSphere(),u.map??=tE(o.columns,o.linear.length/3/o.columns);let f=u.map.image.data;for(let g=0;g<o.linear.length;g++)f[g+Math.floor(g/3)]=Ns.toHalfFloat(o.linear[g]);u.map.needsUpdate=!0}drawFrame(t,[[e,n],[s,r]],o){let a=[[e,s],[n,s],[n,r],[e,r]],l=a.flatMap((c,h)=>[...Mi(t,c),...Mi(t,a.at(h-1))]);this.frame.geometry.dispose(),this.frame.geometry.setAttribute("position",new Qt(l,3)),this.frame.material.color.set(o)}material(t,e,n){let s=this.materials.get(t)??new tr({color:e,linewidth:n});return this.materials.set(t,s),s}clearLines(){for(let t of this.lines.children)t.geometry.dispose();this.lines.clear()}};function tE(i,t){let e=Ns.toHalfFloat(1),n=new Us(new Uint16Array(4*i*t).fill(e),i,t,_n,xn);return n.minFilter=n.magFilter=Be,n}var nd=[.1741,.005,.174,.005,.1738,.0049,.1736,.0049,.1733,.0048,.173,.0048,.1726,.0048,.1721,.0048,.1714,.0051,.1703,.0058,.1689,.0069,.1669,.0086,.1644,.0109,.1611,.0138,.1566,.0177,.151,.0227,.144,.0297,.1355,.0399,.1241,.0578,.1096,.0868,.0913,.1327,.0687,.2007,.0454,.295,.0235,.4127,.0082,.5384,.0039,.6548,.0139,.7502,.0389,.812,.0743,.8338,.1142,.8262,.1547,.8059,.1929,.7816,.2296,.7543,.2658,.7243,.3016,.6923,.3374,.6588,.3731,.6245,.4087,.5896,.4441,.5547,.4788,.5202,.5125,.4866,.5448,.4544,.5752,.4242,.6029,.3965,.627,.3725,.6482,.3514,.6658,.334,.6801,.3197,.6915,.3083,.7006,.2993,.7079,.292,.714,.2859,.719,.2809,.723,.2769,.726,.274,.7283,.2717,.73,.27,.7311,.2689,.732,.268,.7327,.2673,.7334,.2666,.734,.266,.7344,.2656,.7346,.2654,.7347,.2653],Xg=Array.from({length:nd.length/2},(i,t)=>[nd[2*t],nd[2*t+1]]);var Yg=[{name:"D50",xy:[.34567,.35851]},{name:"D65",xy:[.3127,.329]}],jg={xy:{name:"CIE 1931",x:[-.05,.8],y:[-.05,.9],labels:["_x_","_y_"]},uv:{name:"CIE 1976",x:[-.06,.66],y:[-.04,.66],labels:["_u_′","_v_′"]}},bn=128,iE=25,sE=420;function id([i,t],e){let n=-2*i+12*t+3;return e==="xy"?[i,t]:[4*i/n,9*t/n]}function Zg(i,{diagram:t="xy",size:e,theme:n,whites:s=Yg}){let{name:r,x:o,y:a,labels:l}=jg[t],c=new Gi({size:e,theme:n,title:`Chromaticity, ${r} ${l.map(d=>d.replaceAll("_","")).join(" ")}`,caption:"The curve is light of one wavelength, in nm. Colours of the area are approximate.",x:{range:o,label:l[0]},y:{range:a,label:l[1]},isEqual:!0,legend:i.map(({name:d,colour:u=n.text},f)=>({name:d,style:{stroke:u,width:1.8,dash:bi[f%bi.length]}})),legendAt:e.width<sE||i.length>3?"below":t==="xy"?"top":"bottom"}),h=Xg.map(d=>id(d,t));c.image(oE(t),o,a,c.path(h),.85),c.polygon(h,{stroke:n.text,width:1.2}),rE(c,h,n),i.forEach(({corners:d,colour:u=n.text},f)=>{let g=d.map(x=>id(x,t));c.polygon(g,{stroke:u,width:1.8,dash:bi[f%bi.length],rim:!0})});for(let d of s){let u=id(d.xy,t);c.point(u,{});let f=d.xy[0]>.325;c.text(u,d.name,[f?7:-7,0],f?"start":"end")}return c.svg()}function rE(i,t,e){let n=[-1/0,-1/0];t.forEach(([s,r],o)=>{let a=380+o*5;if(a%10!==0||o===0)return;let[l,c]=[t[o-1],t[Math.min(o+1,t.length-1)]],[h,d]=[i.x(c[0])-i.x(l[0]),i.y(c[1])-i.y(l[1])],u=Math.hypot(h,d),f=[i.x(s),i.y(r)];if(u<2||Math.hypot(f[0]-n[0],f[1]-n[1])<iE)return;n=f;let g=[d/u,-h/u];i.point([s,r],{fill:e.text,stroke:e.back,width:.8},2.5);let x=g[0]>.35?"start":g[0]<-.35?"end":"middle";i.text([s,r],String(a),[7*g[0],9*g[1]],x,e.soft)})}var qg=new Map;function oE(i){let t=qg.get(i);if(t!==void 0)return t;let{x:e,y:n}=jg[i],s=new Float32Array(3*bn*bn);for(let u=0;u<bn*bn;u++){let f=e[0]+(u%bn+.5)/bn*(e[1]-e[0]),g=n[1]-(Math.floor(u/bn)+.5)/bn*(n[1]-n[0]),x=6*f-16*g+12,p=i==="xy"?[f,g]:[9*f/x,4*g/x];s.set([p[0],p[1],1-p[0]-p[1]],3*u)}let[,r]=Yg,[o,a]=r.xy,c=Nl({name:"CIEXYZ",reference_white_xyz:[o/a,1,(1-o-a)/a]}).linear(s,"srgb",!1),h=new Uint8ClampedArray(4*bn*bn).fill(255);for(let u=0;u<bn*bn;u++){let f=c.subarray(3*u,3*u+3).map(x=>Math.max(x,0)),g=Math.max(...f,1e-6);f.forEach((x,p)=>h[4*u+p]=255*Jr(x/g))}let d=Ol(h,bn);return qg.set(i,d),d}var Rc={xy:"Chromaticity diagram x, y",uv:"Chromaticity diagram u′, v′"};function po(i){return i in Rc}function Kg(i,t,e){let n=t.flatMap(({slot:s,gamut:r})=>{let o=r.chromaticity?.corners;return o?[{name:r.name,corners:o,colour:Ze(s,e)}]:[]});return n.length===0?"The chromaticities of this gamut are not known: its colours are relative to no stated white.":s=>({svg:Zg(n,{diagram:i,...s})})}function Jg(i,{shown:t}){return`${Rc[i]}: ${t.map(({gamut:e})=>e.name).join(" and ")}`}function Qg({labels:[i,t],frame:[e,n],...s},r,o){let a=({colour:p,order:m})=>({stroke:p,width:2,dash:bi[m]}),l=r.map(p=>({name:p.name,style:a(p)})),c={x:{range:e,label:i},y:{range:n,label:t}},h=new Gi({...s,...c,isEqual:!0,legend:l,legendAt:"below"}),d=p=>p.map(m=>h.path(m)).join(""),u=r.filter(({isFilled:p})=>p).map(({outlines:p})=>d(p));for(let p of u)h.image(o.address,...o.frame,p);for(let p of r.toReversed())h.draw(d(p.outlines),{...a(p),rim:!0});let[f,g]=[h.x(0),h.y(0)],x=(p,m)=>{let _=[(p-f)/(h.x(1)-f),(m-g)/(h.y(1)-g)],M=([y,T],E)=>E>=y&&E<=T;return M(e,_[0])&&M(n,_[1])?[..._]:null};return{svg:h.svg(),placeAt:x}}var wi=96,t0=.05,Pc=class{cut;plane;frame;title;name;box;lightness;space;axes;raster;layers;constructor(t,e,n){let{gamut:s,slot:r}=t[0];this.space=sn(s),this.axes=Se(s),this.box=lE(t.map(h=>h.gamut));let{lightness:o}=this.space;this.lightness=o,this.cut=this.cutOf(n,sd(s)),this.plane=td(this.cut,o);let{kind:a,value:l}=this.cut;this.title=a==="hue"?`Hue ${je(l,4)}°`:`${this.axes[o]} ${je(l,4)}`,this.name=`${t.map(h=>h.gamut.name).join(" and ")}, ${this.title}`,this.layers=t.map(({slot:h,gamut:{name:d},layer:u})=>{let{positions:f,faces:g}=u.level,x=zg(f,g,Hg(this.plane)),{isVisible:p,opacity:m}=e.lookOf(h);return{layer:u,name:d,outlines:x.map(_=>ed(this.plane,_)),isFilled:p&&(m===1||h===r),colour:Ze(h,e.isDark),order:ue.indexOf(h)}});let c=cE(t.map(({layer:h})=>h.level.positions),this.otherAxes);this.frame=hE(this.cut,this.plane,this.box,c),this.raster=e0(this.space,this.plane,this.frame,ge)}get otherAxes(){return[0,1,2].filter(t=>t!==this.lightness)}inView(t,{text:e,back:n}){let{plane:s,frame:r,raster:o}=this,a=this.layers.filter(({layer:l})=>l.isVisible);return{plane:s,turn:yn(this.axes),frame:r,raster:o,layers:a,half:t,ink:e,back:n}}handlePoints(t){let[[e,n],[s,r]]=this.frame,o=td({...this.cut,value:t},this.lightness),a=this.cut.kind==="hue"?(s+r)/2:s;return[Mi(o,[n,a]),Mi(o,[e,a])]}chart(){let{axes:t,cut:e,frame:n,lightness:s,plane:r,raster:o,space:a,title:l}=this,c=e.kind==="hue",h=this.layers.map(p=>{let m=c?p.outlines.map(Gg).filter(_=>_.length>0):p.outlines;return{...p,outlines:m,name:`${p.name}, area ${aE(Vg(m))}`}}),[d,u]=this.otherAxes.map(p=>`_${t[p]}_`),f=c?["Chroma",`_${t[s]}_`]:[d,u],g=c?[[0,n[0][1]],n[1]]:n,x=Ol(uE(ge==="srgb"?o:e0(a,r,n,"srgb")),wi);return p=>{let{svg:m,placeAt:_}=Qg({...p,title:l,labels:f,frame:g},h,{address:x,frame:n});return{svg:m,pointAt:(y,T)=>{let E=_(y,T);return E&&Mi(r,E)}}}}cutOf({kind:t,lightness:e,hue:n},s){if(t==="hue")return{kind:t,value:n};let[r,o]=[this.box.min,this.box.max].map(l=>l.getComponent(this.lightness));return{kind:"lightness",value:e!==null&&e>=r&&e<=o?e:s}}};function aE(i){return i>=100?Math.round(i).toLocaleString("en"):je(i,4)}function lE(i){let t=new ve;for(let{bounds:e}of i)for(let n of e)t.expandByPoint(new P().fromArray(n));return t}function sd(i){let{lightness:t}=sn(i),[e,n]=i.bounds.map(r=>r[t]),s=10**Math.ceil(Math.log10(n/1.05));return n>.7*s&&e<.5*s?s/2:Number(((e+n)/2).toPrecision(2))}function cE(i,t){let e=0;for(let n of i)for(let s=0;s<n.length;s+=3){let r=0;for(let o of t)r+=n[s+o]**2;e=Math.max(e,r)}return Math.sqrt(e)}function hE(i,t,e,n){let s=(a,l)=>[a+t0*(a-l),l+t0*(l-a)],[r,o]=ed(t,[...e.min.toArray(),...e.max.toArray()]);return[i.kind==="hue"?s(-n,n):s(r[0],o[0]),s(r[1],o[1])]}function e0(i,t,[[e,n],[s,r]],o){let{origin:a,right:l,up:c}=t,h=new Float32Array(3*wi*wi);for(let d=0;d<wi;d++)for(let u=0;u<wi;u++){let f=e+(u+.5)/wi*(n-e),g=r-(d+.5)/wi*(r-s),x=3*(d*wi+u);for(let p=0;p<3;p++)h[x+p]=a[p]+f*l[p]+g*c[p]}return{linear:i.linear(h,o),columns:wi}}function uE({linear:i}){let t=new Uint8ClampedArray(4*i.length/3).fill(255);for(let e=0;e<i.length;e++)t[e+Math.floor(e/3)]=255*Jr(i[e]);return t}var n0=["svg","png"],rd=200,dE=20,fE=3,Ic=class{box=L("section-chart");figure=L("section");draw=null;svg="";name="";pointAt=()=>null;constructor(t){for(let e of n0)L(`section-${e}`).addEventListener("click",()=>{fc(this.svg,this.name,e,fE)});L("section-close").addEventListener("click",t),this.connectSize(),new ResizeObserver(()=>this.redraw()).observe(this.box)}get isBelow(){return this.figure.getBoundingClientRect().top>L("stage").getBoundingClientRect().top+10}get size(){return this.draw&&{width:this.figure.offsetWidth,height:this.figure.offsetHeight}}svgFor(t){return this.draw?.(t).svg??""}open(){this.figure.hidden=!1}close(){this.figure.hidden=!0,this.draw=null,this.pointAt=()=>null,this.box.replaceChildren()}show(t,e){this.draw=t,this.name=e,this.redraw()}say(t){this.draw=null,this.pointAt=()=>null,this.box.replaceChildren(tt("p",t,{className:"note"})),this.enableSaving()}redraw(){if(this.draw===null)return;let{clientWidth:t,clientHeight:e}=this.box,n={width:Math.max(rd,t),height:Math.max(rd,e)},{svg:s,pointAt:r=()=>null}=this.draw({size:n,theme:Vi(this.box)});Object.assign(this,{svg:s,pointAt:r}),zu(this.box,s),this.enableSaving()}enableSaving(){for(let t of n0)L(`section-${t}`).disabled=this.draw===null}connectSize(){let t=L("section-size"),e=()=>this.isBelow,n=a=>{let l=this.figure.parentElement.getBoundingClientRect(),c=.6*(e()?l.height:l.width),h=Math.round(Math.min(Math.max(a,rd+40),c));document.documentElement.style.setProperty("--section",`${h}px`),t.setAttribute("aria-valuenow",String(h)),t.setAttribute("aria-valuemax",String(Math.round(c)))},s=()=>t.setAttribute("aria-orientation",e()?"horizontal":"vertical");new ResizeObserver(s).observe(this.figure);let r=()=>e()?this.figure.offsetHeight:this.figure.offsetWidth,o=null;t.addEventListener("pointerdown",a=>{t.setPointerCapture(a.pointerId),o=r()+(e()?a.clientY:a.clientX)}),t.addEventListener("pointermove",a=>{o!==null&&n(o-(e()?a.clientY:a.clientX))});for(let a of["pointerup","pointercancel"])t.addEventListener(a,()=>o=null);t.addEventListener("keydown",a=>{let l={ArrowLeft:1,ArrowUp:1,ArrowRight:-1,ArrowDown:-1}[a.key];l!==void 0&&(a.preventDefault(),n(r()+l*dE))})}};var i0=["lightness","hue"];function mo(i){return i0.includes(i)}function s0(i,t){let e=t.get("diagram");e!==null&&po(e)&&(i.kind=e);for(let s of i0){let r=t.get(s);r===null||!Number.isFinite(Number(r))||(i.kind=s,i[s]=Number(r))}let n=t.get("cut");n!==null&&["above","below","none"].includes(n)&&(i.half=n)}function r0({kind:i,lightness:t,hue:e,half:n}){return i==="off"?[]:po(i)?[["diagram",i]]:[[i,String(i==="hue"?e:t)],["cut",n==="front"?null:n]]}var pE={lightness:"All colours of one lightness.",hue:"All colours of one hue: an angle around the grey axis. Chroma is the distance from grey.",xy:"Colours without their lightness. The colours of the spectrum are on the curve around them.",uv:"Colours without their lightness. The colours of the spectrum are on the curve around them."},Lc=class{kind=L("slice-kind");value=L("slice-value");number=L("slice-number");open=L("slice-open");constructor(t,e){let{kind:n,number:s,open:r,value:o}=this,a=tt("optgroup","",{label:"Diagrams"});a.append(...Object.entries(Rc).map(([l,c])=>tt("option",c,{value:l}))),n.append(a),n.addEventListener("change",()=>t({kind:n.value,half:"front"})),o.addEventListener("input",()=>t({[n.value]:o.valueAsNumber})),s.addEventListener("change",()=>{let{max:l,min:c,valueAsNumber:h}=s,d=Number.isNaN(h)?o.valueAsNumber:Math.min(Math.max(h,Number(c)),Number(l));s.value=String(d),t({[n.value]:d})}),L("slice-flip").addEventListener("click",()=>t({half:e()?"below":"above"})),r.addEventListener("change",()=>t({half:r.checked?"front":"none"}))}show({kind:t,half:e},n,s){let r=n&&mo(t),o=n?pE[t]:void 0;this.kind.value=t,this.kind.disabled=!s,L("slice-note").hidden=o===void 0,L("slice-note").textContent=o??"",L("slice-row").hidden=L("slice-half").hidden=!r,this.open.checked=e!=="none",L("slice-flip").disabled=e==="none"}offerHue(t){L("slice-hue").disabled=!t}setValue({kind:t,value:e},n,s,r){let[o,a]=[s.min.getComponent(r),s.max.getComponent(r)],[l,c,h]=t==="hue"?[0,360,1]:[o,a,10**Math.round(Math.log10((a-o)/100))],d=Math.max(0,Math.ceil(-Math.log10(h))),[u,f]=[Math.ceil(l/h),Math.floor(c/h)].map(g=>(g*h).toFixed(d));Object.assign(this.value,{min:u,max:f,step:String(h)}),Object.assign(this.number,{min:u,max:f,step:"any"}),this.value.value=String(e),document.activeElement!==this.number&&(this.number.value=String(e)),L("slice-label").textContent=n}};var mE=120,gE=100,Dc=class{constructor(t,e){this.page=t;this.readout=e;this.cut=new Cc(t.view),this.handle=new Al(t),this.controls=new Lc(n=>this.change(n),()=>this.cut.isAboveCut),t.address.add({read:n=>{s0(this.state,n),this.state.kind!=="off"&&sr("cut")},write:()=>r0(this.state)}),t.on(["slots","looks","level","theme"],()=>this.draw()),t.on(["camera"],()=>this.cut.follow()),t.readable.push({targets:()=>mo(this.state.kind)?[this.cut.cap]:[],read:({point:n})=>this.read(this.cut.pointOf(n))}),this.connectChart()}page;readout;state={kind:"off",lightness:null,hue:40,half:"front"};cut;handle;controls;figure=new Ic(()=>this.change({kind:"off"}));recipe=new Qs(mE);space="";charted=-1/0;charting=0;connectChart(){let{figure:t,readout:e}=this,{box:n}=t,s=({clientX:r,clientY:o})=>{let{left:a,top:l}=n.getBoundingClientRect(),c=t.pointAt(r-a,o-l);c===null?e.leave():this.read(c)};for(let r of["pointermove","pointerdown"])n.addEventListener(r,o=>e.isKept||s(o));n.addEventListener("click",r=>e.click(r,()=>s(r))),n.addEventListener("pointerleave",r=>{r.pointerType==="mouse"&&e.leave()})}change(t){Object.assign(this.state,t),this.readout.release(),this.draw(),this.page.view.draw(),this.page.address.save()}draw(){clearTimeout(this.charting);let{cut:t,controls:e,figure:n,handle:s,page:r,state:o}=this,a=r.shown.filter(({layer:h})=>h.level!==null);a.length>0&&this.followSpace(a[0].gamut);let l=o.kind!=="off"&&a.length>0;if(e.show(o,l,r.shown.length>0),(!l||!mo(o.kind))&&(t.hide(a.map(({layer:h})=>h)),s.hide()),!l)return n.close();if(n.open(),!po(o.kind))return this.drawPlane(a);let c=Kg(o.kind,a,r.isDark);typeof c=="string"?n.say(c):n.show(c,Jg(o.kind,r))}followSpace(t){let{state:e}=this,n=sn(t).lightness===0;this.controls.offerHue(n),!n&&e.kind==="hue"&&(e.kind="lightness");let{space:s}=t.options;this.space!==""&&this.space!==s&&(e.lightness=null),this.space=s,e.lightness??=sd(t)}drawPlane(t){let{controls:e,cut:n,figure:s,handle:r,page:o,state:a}=this,l=new Pc(t,o,a),{value:c}=l.cut;e.setValue(l.cut,l.title,l.box,l.lightness),n.show(l.inView(a.half,Vi(s.box))),r.show(h=>n.screen(l.handlePoints(h)[0]),l.title,l.cut.kind==="hue"?{place:()=>n.screen(l.handlePoints(c)[1]),text:`Hue ${(c+180)%360}°`}:void 0),this.chartLater(()=>s.show(l.chart(),l.name))}chartLater(t){let e=()=>{this.charted=performance.now(),t()},n=this.charted+gE-performance.now();n<=0?e():this.charting=setTimeout(e,n)}read(t){let e=this.page.shown[0],{gamut:n}=e,s=Jn(sn(n).linear(Float32Array.from(t),ge));qt!==null||!cc(n)?this.recipe.clear():this.recipe.ask(r=>Pg(n,t,r),"Recipe: …"),this.readout.show({subject:e,point:t,colour:s,lines:Zu(Se(n),t),answer:this.recipe})}};var Ke=16,od=16,$i=13,ad=11.5,Nc=18,ld=24,o0=9,vE=480,a0=560;async function l0(i,t){let e=await cd(i,t);return new Promise((n,s)=>e.toBlob(r=>r===null?s(new Error("This browser cannot save so large a picture. Choose a smaller one.")):n(r)))}async function cd(i,t){let e=xE(t);return await _E(e,i,t),e.canvas}function xE({width:i,height:t,ratio:e}){let n=document.createElement("canvas");n.width=Math.floor(i*e),n.height=Math.floor(t*e);let s=n.getContext("2d",{colorSpace:ge});if(s===null)throw new Error("This browser cannot draw so large a picture. Choose a smaller one.");return s}async function _E(i,t,e){let{canvas:n}=i,s=t.at({...e,...c0(e)},yE(e),(o,a)=>(i.clearRect(0,0,n.width,n.height),i.fillStyle=e.ground,e.isClear||i.fillRect(0,0,n.width,n.height),i.drawImage(o,0,0),bE(e,a))),r=new Image;r.src=`data:image/svg+xml,${encodeURIComponent(s)}`,await r.decode(),i.drawImage(r,0,0,n.width,n.height)}function c0({width:i,height:t,bars:e,chart:n}){let s=n===null||n.isBelow?i:i-n.width,r=n?.isBelow?t-n.height:t,o=ld+(s<a0?ld/2:0);return{width:s,height:r-(e.length===0?0:Ke/2+o*e.length)}}function yE({legend:i,note:t}){return{left:0,right:0,top:Ke+od+Nc*i.length+6,bottom:t===""?0:Ke+ad}}function bE(i,t){let{width:e,height:n,ratio:s,title:r,legend:o,note:a,bars:l,chart:c,colour:h,line:d,ground:u}=i,f=c0(i),g=(_,M,y,T,E="")=>`<text x="${_.toFixed(1)}" y="${M.toFixed(1)}" font-size="${y}"${E}>${Xn(T)}</text>`,x=f.width-2*Ke,p=[g(Ke,Ke+12,od,go(r,od,x),' font-weight="600"'),...o.flatMap(({text:_,figure:M,colour:y},T)=>{let E=Ke+14+Nc*(T+1),v=go(_,$i,x-Nc-vo(M,$i));return[`<circle cx="${Ke+5}" cy="${E-4.5}" r="5" fill="${y}"/>`,g(Ke+Nc,E,$i,v+M)]}),g(Ke,f.height-Ke+4,ad,go(a,ad,x))],m=t.map(({text:_,x:M,y,meaning:T})=>g(M,y,Hl,_,` dy=".35em"${T===null?"":' font-weight="600"'}`));return[`<svg xmlns="http://www.w3.org/2000/svg" width="${e*s}" height="${n*s}" viewBox="0 0 ${e} ${n}">`,`<g font-family="${zl.replaceAll('"',"'")}" fill="${h}" stroke="${u}" stroke-width="3.5" stroke-linejoin="round" paint-order="stroke">`,...p,...SE(l,f,d,g),c===null?"":`<g transform="translate(${c.isBelow?`0 ${n-c.height}`:`${f.width} ${(n-c.height)/2}`})">${c.svg}</g>`,'<g text-anchor="middle">',...m,"</g></g></svg>"].join(`
`)}function SE(i,{width:t,height:e},n,s){let r=t>=a0,o=t-2*Ke,a=i.map(({name:c,other:h,text:d})=>{let u=` covers ${d} of `,f=((r?.6:1)*o-vo(u,$i))/2;return go(c,$i,f)+u+go(h,$i,f)}),l=Ke+(r?Math.max(...a.map(c=>vo(c,$i)))+Ke:0);return i.flatMap(({share:c,colour:h},d)=>{let u=e+13+ld*(r?1:1.5)*d,f=Math.min(vE,Ke+o-l),g=(x,p)=>`<rect x="${l.toFixed(1)}" y="${r?u-o0:u+6}" width="${(x*f).toFixed(1)}" height="${o0}" fill="${p}"/>`;return[s(Ke,u,$i,a[d]),g(1,n),g(c,h)]})}function vo(i,t){let e=document.createElement("canvas").getContext("2d");return e.font=`600 ${t}px ${zl}`,e.measureText(i).width}function go(i,t,e){if(vo(i,t)<=e)return i;let n=i.length;for(;n>1&&vo(`${i.slice(0,n)}…`,t)>e;)n-=1;return`${i.slice(0,n).trimEnd()}…`}var ME={png:"The view with title, legend and scales, and what is open of section and Compare.",html:"One file with all that is shown and the list of colours. It works without a network."},wE={width:1280,height:720,ratio:1.5},EE=.4,AE=1.25;function h0(i,t){let e=L("take-away"),n=L("save-kind"),s=L("save-file"),r=L("save-close"),o=L("save-preview"),a=new be,l=new be,c=()=>{let d=n.value;for(let u of e.querySelectorAll(".of-picture"))u.hidden=d!=="png";L("save-note").textContent=ME[d],L("save-clear-note").hidden=d!=="png"||!u0(),s.disabled=i.shown.length===0||a.isAsking,r.textContent=a.isAsking?"Cancel":"Close"},h=()=>{if(l.end(),!e.open||n.value==="html"||i.shown.length===0)return o.replaceChildren();let d=d0(i,t),{width:u,height:f,ratio:g}=d,x=[u,f].map(m=>Math.floor(m*g)).join(" × "),p=o.clientWidth*devicePixelRatio/u;l.ask(()=>cd(i.view,{...d,ratio:Math.min(g,p)}),m=>{m.setAttribute("role","img"),m.setAttribute("aria-label",`Preview: ${d.title}`),m.classList.toggle("clear",d.isClear),o.replaceChildren(m,tt("p",`${x} pixels`,{className:"note"}))},m=>o.replaceChildren(tt("p",String(m),{className:"note"})))};L("save").addEventListener("click",()=>{c(),e.showModal(),h()}),e.addEventListener("change",()=>{c(),h()}),i.on(["level"],()=>e.open&&h()),r.addEventListener("click",()=>{if(!a.isAsking)return e.close();a.end(),c()}),e.addEventListener("close",()=>{a.end(),h()}),s.addEventListener("click",()=>{let d=i.shown.map(({gamut:f})=>f.name).join(" and "),u=n.value;a.ask(f=>CE(i,u,t,f),f=>{Zi(f,`${d}.${u}`),e.close(),i.announce("The file was saved.")},f=>{c(),L("save-note").textContent=f instanceof Error?f.message:String(f)}),c()}),L("share").addEventListener("click",()=>{(navigator.clipboard?.writeText(TE(i))??Promise.reject(new Error)).then(()=>"The link was copied.",()=>"This browser does not let the page copy. The link is in the address bar.").then(u=>i.board.note(u))})}function TE(i){let t=i.at("a");if(t===null||t.isPart||Md())return`${ji("/view")}#${i.address.text}`;let e=i.address.text.split("&").filter(n=>!n.startsWith("a="));return`${ji(`/v1/gamuts/${t.gamut.id}`)}#${e.join("&")}`}async function CE(i,t,e,n){if(t==="html"){let[s,...r]=i.shown.map(({gamut:h})=>h.id),o=new URLSearchParams(i.address.text);for(let{slot:h,gamut:d}of i.shown)o.set(h,d.id);let a=`/v1/gamuts/${s}/viewer.html${r.length===0?"":`?with=${r.join(",")}`}`,l=Object.fromEntries([...i.kept].map(([h,d])=>[h,d()])),c=await Ee(a,{headers:{Accept:"text/html"},signal:n});return new Blob([Ld(await c.text(),{address:String(o),...l})],{type:"text/html"})}return l0(i.view,d0(i,e))}function u0(){return L("save-clear").checked}function d0(i,{figure:t,comparison:e}){let{axes:n}=i.view,{gamut:s}=i.shown[0],{space:r}=s.options,o=n===null?"":`: lines of the grid are ${n.step} apart in ${Se(s).join(", ")}`,a=L("plane-handle").hidden?"":`; cut at ${L("plane-text").textContent}`,l=L("stage"),c=L("save-shape").value==="wide",h={...Vi(l,"--stage"),isClear:!0},{bars:d}=e,u=t.size,f=!c&&t.isBelow,g=c?wE:{width:l.clientWidth+(f?0:u?.width??0),height:l.clientHeight+(f?u?.height??0:0),ratio:1},x=c?EE*g.width:u?.width??0,p=f?u:u&&{width:x,height:Math.min(g.height,AE*x)};return{...g,ratio:g.ratio*Number(L("save-ratio").value),title:i.shown.map(m=>m.gamut.name).join(" and "),legend:i.shown.filter(({slot:m})=>i.lookOf(m).isVisible).map(({slot:m,gamut:_})=>({text:_.name,figure:d.length===0?"":`, ${Ys(_)} ${Si(_)}`,colour:Ze(m,i.isDark)})),note:`${r}${o}${a}; colours for ${ge==="srgb"?"sRGB":"Display P3"} screens`,bars:d.map(m=>({...m,colour:Ze(m.slot,i.isDark)})),chart:p&&{svg:t.svgFor({size:p,theme:h}),...p,isBelow:f},colour:h.text,line:h.line,ground:h.back,isClear:u0()}}function RE(){let i=new Kl;fg(i),xg(i),gg(i);let t=new Mc(i);Dg(i,t),qm(i),Ud(),jm(),new gc(i);let{figure:e}=new Dc(i,t),n=new dc(i);return new xc(i,n),h0(i,{figure:e,comparison:new pc(i)}),qt===null?(new sc(i,{colours:n,picture:new _c(i)}),new vc(i)):L("title").textContent=qt.gamuts.map(({gamut:s})=>s.name).join(" and "),Km(i),i}try{window.gamutViewer=RE()}catch(i){document.getElementById("static-note")?.removeAttribute("hidden");let t=L("problem");t.hidden=!1,t.append(tt("strong","This browser cannot show the view"),tt("p",String(i)))}
